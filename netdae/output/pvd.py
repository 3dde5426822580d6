"""The frames of a ParaView time series beside the .pvd file that names them: frames/frame_000000.vtu and so on.

Every file gets its name when it is complete, the .pvd after the frame: at any moment, also after a kill, it names only
complete frames. The .pvd is rewritten at every frame up to 1000, then each time it has grown by a thousandth, so that
the cost per frame does not grow, and at the end.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of, write_whole

if TYPE_CHECKING:
    import os

_HEAD = b"""<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
<Collection>
"""
_TAIL = b"""</Collection>
</VTKFile>
"""
_EVERY_FRAME_UP_TO = 1000


class PvdSeries:
    """A .pvd file with its frames, in the folder `frames` beside it.

    path : the .pvd file
    stem, suffix : of the frames' names
    """

    def __init__(self, path: str | os.PathLike[str], *, stem: str = "frame", suffix: str = ".vtu") -> None:
        self.path = Path(path)
        self.frame_count = 0
        self._stem, self._suffix = stem, suffix
        self._file = re.compile(rf"{stem}_(\d{{6,}}){re.escape(suffix)}(\.part)?")
        self._named = 0
        self._entries = bytearray()
        if self.path.suffix != ".pvd":
            raise InputError(f"{self.path} is not a series: give a file that ends in .pvd")

    def begin(self) -> None:
        """Clear a former series and write one without frames; raises InputError where nothing can be written."""
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

    def resume(self, count: int, time_of: Callable[[Path], float]) -> None:
        """Keep the first frames, remove later ones; raises InputError where one is missing.

        time_of : the time that a frame holds, for those that a kill left unnamed
        """
        times = [t for t, _ in read_series(self.path)][:count]
        for number in range(count):
            file = self.path.parent / self._name_of(number)
            if not file.is_file():
                raise InputError(f"{file} is missing: the series cannot be gone on from without it")
            if number >= len(times):  # killed before the .pvd named it
                times.append(time_of(file))
        self.frame_count = count
        self._entries[:] = b"".join(self._entry_of(number, t) for number, t in enumerate(times))
        try:
            self._name_frames()
            self._clear_from(count)
        except OSError as error:
            raise InputError(f"{self.path} cannot be gone on from: {reason_of(error)}") from error

    def add(self, t: float, data: bytes) -> None:
        """Write the frame at t, s; raises RunError where it cannot be."""
        name = self._name_of(self.frame_count)
        try:
            write_whole(self.path.parent / name, data)
            self._entries += self._entry_of(self.frame_count, t)
            self.frame_count += 1
            if self.frame_count - self._named > self._named // _EVERY_FRAME_UP_TO:
                self._name_frames()
        except OSError as error:
            raise RunError(
                f"{name} at t = {t:g} s could not be written beside {self.path}: {reason_of(error)}; "
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

    @property
    def _folder(self) -> Path:
        return self.path.parent / "frames"

    def _name_of(self, number: int) -> str:
        return f"frames/{self._stem}_{number:06d}{self._suffix}"

    def _entry_of(self, number: int, t: float) -> bytes:
        return f'  <DataSet timestep="{float(t)!r}" part="0" file="{self._name_of(number)}"/>\n'.encode()

    def _clear_from(self, number: int) -> None:
        """Remove the frames from that number on, and what a kill left of one."""
        for file in self._folder.iterdir():
            found = self._file.fullmatch(file.name)
            if found and (found[2] or int(found[1]) >= number):
                file.unlink()

    def _name_frames(self) -> None:
        write_whole(self.path, _HEAD + self._entries + _TAIL)
        self._named = self.frame_count


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
