"""Frames of a flight as a ParaView time series: frames/frame_000000.vtu ... and the .pvd that names them.

Points are x; point data displacement (x − x̄, m), velocity (m/s), acceleration (m/s²), mass (kg); cell data
strain (E11), stress (S11, Pa), tension (N), taut (uint8); groups are uint8 arrays group_<name>. Point data
restrained (uint8) is how many axes of a node are held or driven in the frame; frames of former versions lack it. With
a target or obstacles there are also contact_force (N, of these on the node) and contact_gap (m, to the nearest of them,
less the radius of the node's cords).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv
from pyvista.core.utilities.writer import XMLUnstructuredGridWriter

from netdae.core.arrays import IntArray
from netdae.core.errors import InputError
from netdae.core.files import reason_of
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.output.pvd import PvdSeries
from netdae.system.meeting import Meeting

if TYPE_CHECKING:
    import os

    from netdae.model.restraints import Restraint
    from netdae.system.system import System

POINT_DATA = ("displacement", "velocity", "acceleration", "mass")
"""Point arrays of every frame."""
RESTRAINED = "restrained"
"""Point array of how many axes are held or driven; older frames lack it."""
CELL_DATA = ("strain", "stress", "tension", "taut")
"""Cell arrays of every frame."""


class VtuSeries:
    """Observer that writes each frame as a .vtu file and names it in a .pvd file.

    path : the .pvd file; the frames go to the folder `frames` beside it, which is made.
    groups : whether the net's node and cable groups are written too, to select by in ParaView
    fired : returns at each frame the times of the events that have happened, by name; for restraints that begin or end
        at events, for instance `lambda: detector.fired` of an `EventDetector`

    A former series at the same place is replaced; see `pvd` for when files get their names. Raises InputError where
    nothing can be written, RunError when a frame cannot be.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        groups: bool = True,
        fired: Callable[[], Mapping[str, float]] = dict,
    ) -> None:
        self.groups = groups
        self.fired = fired
        self._files = PvdSeries(path)
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
        """Clear a former series, write one without frames, and make the grid."""
        self._make_grid(system)
        self._files.begin()

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the frames that the flight has yielded, remove later ones; raises InputError where one is missing."""
        self._make_grid(system)
        # VTK writes the first frame of a writer differently from later ones: let that be none of the flight's
        self._frame(State.at(system.net.nodes))
        self._files.resume(int(memory["frames"]), _time_of)

    def _make_grid(self, system: System) -> None:
        self._system = system
        shown = system.in_space.copy()
        if system.body is not None:
            shown[system.body.place] = False  # it has a series of its own
        self._places = np.flatnonzero(shown)
        self._grid = grid_of(system.net, groups=self.groups, nodes=self._places)
        self._grid.point_data["mass"] = system.mass[self._places]
        meeting = Meeting(system)
        self._meeting = meeting if meeting.bodies else None
        self._holding: tuple[Restraint, ...] = ()
        self._grid.point_data[RESTRAINED] = np.zeros(len(self._places), dtype=np.uint8)
        self._writer = XMLUnstructuredGridWriter("", self._grid).writer
        self._writer.WriteToOutputStringOn()
        self._writer.SetDataModeToAppended()
        self._writer.EncodeAppendedDataOff()
        self._writer.SetCompressionLevel(1)  # level 5 takes 15 % longer for files 0.5 % smaller

    def __call__(self, state: State) -> None:
        """Write the frame of a State."""
        self._files.add(state.t, self._frame(state))

    def end(self) -> None:
        """Name the frames that the .pvd does not name yet."""
        self._files.end()

    def _frame(self, state: State) -> bytes:
        system, grid = self._system, self._grid
        if system is None:
            raise RuntimeError("VtuSeries was called before begin(system)")
        strain, places = system.strain(state.x), self._places
        x = state.x[places]
        grid.points = x
        grid.point_data["displacement"] = x - system.net.nodes[places]
        grid.point_data["velocity"] = state.v[places]
        grid.point_data["acceleration"] = state.a[places]
        if self._meeting is not None:
            grid.point_data["contact_force"] = self._meeting.forces(state)[places]
            grid.point_data["contact_gap"] = self._meeting.gaps(state)[places]
        self._hold(system, state.t)
        grid.cell_data["strain"] = strain
        grid.cell_data["stress"] = system.stress(state.x)
        grid.cell_data["tension"] = system.tension(state.x)
        grid.cell_data["taut"] = (strain > 0).astype(np.uint8)
        grid.field_data["TimeValue"] = np.array([state.t])  # ParaView's name for a single file's time
        if system.reels:
            grid.field_data["paid_out"] = state.x[[reel.node for reel in system.reels], 0]
        self._writer.Write()
        data: bytes | str = self._writer.GetOutputString()
        return data if isinstance(data, bytes) else data.encode()

    def _hold(self, system: System, t: float) -> None:
        """Mark which axes are held at t, where these differ from those in the previous frame."""
        fired = self.fired()
        holding = tuple(restraint for restraint in system.restraints if restraint.holds(t, fired))
        if holding == self._holding:
            return
        held = np.zeros((system.net.node_count, 3), dtype=np.bool_)
        for restraint in holding:
            held[np.ix_(restraint.nodes_of(system.net), restraint.axis_indices)] = True
        self._grid.point_data[RESTRAINED] = held[self._places].sum(axis=1, dtype=np.uint8)
        self._holding = holding


def _time_of(frame: Path) -> float:
    return float(read_frame(frame).field_data["TimeValue"][0])


def grid_of(net: CableNet, *, groups: bool = True, nodes: IntArray | None = None) -> pv.UnstructuredGrid:
    """The net in its reference positions as a grid of lines, with group_<name> arrays; "all" is left out.

    nodes : (k,), ascending, those that are points: all by default; no cable ends at another node
    """
    m, places = net.cable_count, np.arange(net.node_count) if nodes is None else nodes
    cells = np.column_stack([np.full(m, 2), np.searchsorted(places, net.cables)]).ravel()
    grid = pv.UnstructuredGrid(cells, np.full(m, pv.CellType.LINE, dtype=np.uint8), net.nodes[places])
    if groups:
        _add_groups(grid.point_data, net.node_groups, places)
        _add_groups(grid.cell_data, net.cable_groups, np.arange(m))
    return grid


def _add_groups(data: Any, groups: Any, shown: IntArray) -> None:
    members: IntArray
    for name, members in groups.items():
        mask = np.isin(shown, members).astype(np.uint8)
        if name != "all" and mask.any():
            data["group_" + re.sub(r"[^\w.+-]", "_", name)] = mask  # VTK writes names unescaped into its XML


def read_frame(path: str | os.PathLike[str]) -> pv.UnstructuredGrid:
    """One frame as a grid with the arrays of `POINT_DATA` and `CELL_DATA`.

    Raises InputError for a file that is not there, is cut off, or is not a frame of netdae.
    """
    source = Path(path)
    try:
        with source.open("rb") as stream:
            stream.seek(0, 2)
            stream.seek(max(0, stream.tell() - 64))
            complete = stream.read().rstrip().endswith(b"</VTKFile>")
    except OSError as error:
        raise InputError(f"{source} cannot be read: {reason_of(error)}: give a frame of a series") from error
    if not complete:  # VTK would print pages and return an empty grid
        raise InputError(f"{source} is cut off or no .vtu file: give a frame that the .pvd names")
    grid = pv.XMLUnstructuredGridReader(str(source)).read()
    missing = sorted({*POINT_DATA} - {*grid.point_data}) + sorted({*CELL_DATA} - {*grid.cell_data})
    if missing:
        raise InputError(f"{source} has no {', '.join(missing)}: give a frame that netdae wrote")
    return grid
