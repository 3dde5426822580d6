"""Frames of a flight as a ParaView time series: frames/frame_000000.vtu ... and the .pvd that names them.

Points are x; point data displacement (x − x̄, m), velocity (m/s), acceleration (m/s²), mass (kg); cell data
strain (E11), stress (S11, Pa), tension (N), taut (uint8); groups are uint8 arrays group_<name>. Point data
restrained (uint8) is how many axes of a node are held or driven in the frame; frames of former versions lack it.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv
from pyvista.core.utilities.writer import XMLUnstructuredGridWriter

from netdae.core.arrays import IntArray
from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of, write_whole
from netdae.model.net import CableNet
from netdae.model.state import State

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

_FRAME_FILE = re.compile(r"frame_(\d{6,})\.vtu(\.part)?")
_HEAD = b"""<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
<Collection>
"""
_TAIL = b"""</Collection>
</VTKFile>
"""
_EVERY_FRAME_UP_TO = 1000


class VtuSeries:
    """Observer that writes each frame as a .vtu file and names it in a .pvd file.

    path : the .pvd file; the frames go to the folder `frames` beside it, which is made.
    groups : whether the net's node and cable groups are written too, to select by in ParaView
    fired : returns at each frame the times of the events that have happened, by name; for restraints that begin or end
        at events, for instance `lambda: detector.fired` of an `EventDetector`

    Every file gets its name when it is complete, the .pvd after the frame: at any moment, also after a kill,
    it names only complete frames. A former series at the same place is replaced. The .pvd is rewritten at
    every frame up to 1000, then each time it has grown by a thousandth (the cost per frame does not grow), and
    at the end. Raises InputError where nothing can be written, RunError when a frame cannot be.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        groups: bool = True,
        fired: Callable[[], Mapping[str, float]] = dict,
    ) -> None:
        self.path = Path(path)
        self.groups = groups
        self.fired = fired
        self.frame_count = 0
        self._named = 0
        self._entries = bytearray()
        self._system: System | None = None
        if self.path.suffix != ".pvd":
            raise InputError(f"{self.path} is not a series: give a file that ends in .pvd")

    def begin(self, system: System) -> None:
        """Clear a former series, write one without frames, and make the grid."""
        self._make_grid(system)
        self.frame_count = self._named = 0
        self._entries.clear()
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._name_frames()
            self._clear_from(0)
        except OSError as error:
            raise InputError(
                f"{self.path} cannot be written: {reason_of(error)}: choose another output folder"
            ) from error

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the frames that the flight has yielded, remove later ones; raises InputError where one is missing."""
        self._make_grid(system)
        # VTK writes the first frame of a writer differently from later ones: let that be none of the flight's
        self._frame(State.at(system.net.nodes))
        count = int(memory["frames"])
        times = [t for t, _ in read_series(self.path)][:count]
        for number in range(count):
            file = self.path.parent / _name_of(number)
            if not file.is_file():
                raise InputError(f"{file} is missing: the series cannot be gone on from without it")
            if number >= len(times):  # killed before the .pvd named it
                times.append(float(read_frame(file).field_data["TimeValue"][0]))
        self.frame_count = count
        self._entries[:] = b"".join(_entry_of(number, t) for number, t in enumerate(times))
        try:
            self._name_frames()
            self._clear_from(count)
        except OSError as error:
            raise InputError(f"{self.path} cannot be gone on from: {reason_of(error)}") from error

    @property
    def _folder(self) -> Path:
        return self.path.parent / "frames"

    def _clear_from(self, number: int) -> None:
        """Remove the frames from that number on, and what a kill left of one."""
        for file in self._folder.iterdir():
            found = _FRAME_FILE.fullmatch(file.name)
            if found and (found[2] or int(found[1]) >= number):
                file.unlink()

    def _make_grid(self, system: System) -> None:
        self._system = system
        self._places = np.flatnonzero(system.in_space)
        self._grid = grid_of(system.net, groups=self.groups, nodes=self._places)
        self._grid.point_data["mass"] = system.mass[self._places]
        self._holding: tuple[Restraint, ...] = ()
        self._grid.point_data[RESTRAINED] = np.zeros(len(self._places), dtype=np.uint8)
        self._writer = XMLUnstructuredGridWriter("", self._grid).writer
        self._writer.WriteToOutputStringOn()
        self._writer.SetDataModeToAppended()
        self._writer.EncodeAppendedDataOff()
        self._writer.SetCompressionLevel(1)  # level 5 takes 15 % longer for files 0.5 % smaller

    def __call__(self, state: State) -> None:
        """Write the frame of a State."""
        name = _name_of(self.frame_count)
        try:
            write_whole(self.path.parent / name, self._frame(state))
            self._entries += _entry_of(self.frame_count, state.t)
            self.frame_count += 1
            if self.frame_count - self._named > self._named // _EVERY_FRAME_UP_TO:
                self._name_frames()
        except OSError as error:
            raise RunError(
                f"{name} at t = {state.t:g} s could not be written beside {self.path}: {reason_of(error)}; "
                f"complete frames so far: {self._named}"
            ) from error

    def end(self) -> None:
        """Name the frames that the .pvd does not name yet."""
        if self._named < self.frame_count:
            try:
                self._name_frames()
            except OSError as error:
                raise RunError(
                    f"{self.path} could not be written: {reason_of(error)}; it names {self._named} frames, "
                    "later ones are in the folder beside it"
                ) from error

    def _name_frames(self) -> None:
        write_whole(self.path, _HEAD + self._entries + _TAIL)
        self._named = self.frame_count

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


def _name_of(number: int) -> str:
    return f"frames/frame_{number:06d}.vtu"


def _entry_of(number: int, t: float) -> bytes:
    return f'  <DataSet timestep="{float(t)!r}" part="0" file="{_name_of(number)}"/>\n'.encode()


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


def read_series(path: str | os.PathLike[str]) -> list[tuple[float, Path]]:
    """Times, s, and frame files that a .pvd file names, in its order.

    Raises InputError for a file that is not there or is not a .pvd.
    """
    source = Path(path)
    try:
        root = ET.parse(source).getroot()
        if root.tag != "VTKFile" or root.get("type") != "Collection":
            raise ValueError("it holds no collection of frames")
        entries = root.iter("DataSet")
        return [(float(each.attrib["timestep"]), source.parent / each.attrib["file"]) for each in entries]
    except OSError as error:
        raise InputError(
            f"{source} cannot be read: {reason_of(error)}: give the series.pvd of an output folder"
        ) from error
    except (ET.ParseError, ValueError, KeyError) as error:
        raise InputError(
            f"{source} is not a .pvd series: {error}: give the series.pvd of an output folder"
        ) from error


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
