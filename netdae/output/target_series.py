"""The moving surface of a target as a ParaView time series: frames/target_000000.vtp ... and the .pvd that names them.

Points are those of the surface, with sharp edges; point data velocity (m/s); cell data part (the part's number from 0)
and contact_force (N, of the net on the whole part). Field data: centre (m, of mass), origin (m, of the body's frame),
attitude (quaternion w, x, y, z of this frame), spin (rad/s, about its axes).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv
from pyvista.core.utilities.writer import XMLPolyDataWriter

from netdae.core.arrays import IntArray
from netdae.core.errors import InputError
from netdae.model.shapes.part import Part, axes_of
from netdae.model.shapes.surfaces import joined
from netdae.model.state import State
from netdae.output.pvd import PvdSeries
from netdae.system.meeting import Meeting
from netdae.system.target_state import target_at

if TYPE_CHECKING:
    import os

    from netdae.system.system import System


class TargetSeries:
    """Observer that writes the target's surface at each frame as a .vtp file and names it in a .pvd file.

    path : the .pvd file; the frames go to the folder `frames` beside it, which is made

    Raises InputError where nothing can be written or there is no target, RunError when a frame cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._files = PvdSeries(path, stem="target", suffix=".vtp")
        self._system: System | None = None

    @property
    def path(self) -> Path:
        """The .pvd file."""
        return self._files.path

    @property
    def frame_count(self) -> int:
        """How many frames are written."""
        return self._files.frame_count

    def begin(self, system: System) -> None:
        """Clear a former series, write one without frames, and make the surface."""
        self._make_surface(system)
        self._files.begin()

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the frames that the flight has yielded, remove later ones; raises InputError where one is missing."""
        self._make_surface(system)
        self._written()  # VTK writes the first frame of a writer differently from later ones
        self._files.resume(int(memory["frames"]), _time_of)

    def __call__(self, state: State) -> None:
        """Write the frame of a State."""
        system, surface = self._system, self._surface
        if system is None:
            raise RuntimeError("TargetSeries was called before begin(system)")
        target = target_at(system, state)
        axes, own = axes_of(target.attitude), self._points
        surface.points = target.origin + own @ axes.T
        spin = axes @ target.spin
        surface.point_data["velocity"] = target.velocity + np.cross(spin, surface.points - target.centre)
        surface.field_data["TimeValue"] = np.array([state.t])  # ParaView's name for a single file's time
        surface.cell_data["contact_force"] = self._meeting.part_forces(state)[self._part]
        for name in ("centre", "origin", "attitude", "spin"):
            surface.field_data[name] = getattr(target, name)
        self._files.add(state.t, self._written())

    def end(self) -> None:
        """Name the frames that the .pvd does not name yet."""
        self._files.end()

    def _make_surface(self, system: System) -> None:
        if system.body is None:
            raise InputError(f"{self.path}: there is no target: leave its series out")
        self._system = system
        self._surface = surface_of_parts(system.body.target.parts)
        self._points = np.array(self._surface.points)
        self._part = np.asarray(self._surface.cell_data["part"])
        self._meeting = Meeting(system)
        self._surface.point_data["velocity"] = np.zeros_like(self._points)
        self._writer = XMLPolyDataWriter("", self._surface).writer
        self._writer.WriteToOutputStringOn()
        self._writer.SetDataModeToAppended()
        self._writer.EncodeAppendedDataOff()
        self._writer.SetCompressionLevel(1)

    def _written(self) -> bytes:
        self._writer.Write()
        data: bytes | str = self._writer.GetOutputString()
        return data if isinstance(data, bytes) else data.encode()


def surface_of_parts(parts: tuple[Part, ...]) -> pv.PolyData:
    """Triangles of parts in the frame of their body, with the cell data `part`."""
    surfaces = [part.surface() for part in parts]
    whole = joined(surfaces)
    grid = pv.PolyData.from_regular_faces(np.array(whole.points), whole.triangles)
    number: IntArray = np.repeat(np.arange(len(parts)), [len(each.triangles) for each in surfaces])
    grid.cell_data["part"] = number.astype(np.uint8)
    return grid


def _time_of(frame: Path) -> float:
    return float(pv.XMLPolyDataReader(str(frame)).read().field_data["TimeValue"][0])
