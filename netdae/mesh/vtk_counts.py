"""What the header of a legacy .vtk file promises against what the file holds.

VTK takes memory for the numbers that a file states before it reads them, and follows sizes of cells unchecked: it ends
Python on a damaged file. Hence these checks come before VTK sees one.
"""

from __future__ import annotations

import re

import numpy as np

from netdae.core.arrays import IntArray
from netdae.core.errors import MeshError

_HEAD = re.compile(rb"# vtk DataFile Version (\d+)\.(\d+)[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s+", re.IGNORECASE)
_WORD = re.compile(rb"\s*(\S+)")
_BYTES = {
    "bit": 1, "char": 1, "signed_char": 1, "unsigned_char": 1, "short": 2, "unsigned_short": 2, "int": 4,
    "unsigned_int": 4, "float": 4, "double": 8, "long": 8, "unsigned_long": 8, "vtkidtype": 8,
    "vtktypeint32": 4, "vtktypeint64": 8, "vtktypeuint64": 8, "vtktypeuint32": 4, "long_long": 8,
}  # fmt: skip
_ROWS = {
    "VECTORS": 3,
    "NORMALS": 3,
    "TENSORS": 9,
    "TENSORS6": 6,
    "GLOBAL_IDS": 1,
    "PEDIGREE_IDS": 1,
    "EDGE_FLAGS": 1,
}
_BLANK = re.compile(rb"\n[ \t]*\r?\n")
_CELLS = ("CELLS", "VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS")


def check_legacy(data: bytes) -> None:
    """Raise MeshError for a .vtk file that VTK cannot read safely."""
    head = _HEAD.match(data)
    if head is None:
        raise ValueError("no header of a .vtk file")
    version = int(head[1]), int(head[2])
    if not (1, 0) <= version <= (5, 1):
        raise MeshError(
            f".vtk of version {version[0]}.{version[1]} is not read: save it as version 3.0 or 5.1"
        )
    _Walk(data, head.end(), head[3].upper() == b"ASCII", new=version[0] >= 5).check()


class _Walk:
    """A place in the file that moves from one section to the next."""

    def __init__(self, data: bytes, place: int, text: bool, *, new: bool) -> None:
        self.data, self.place, self.text, self.new = data, place, text, new
        self.points = self.cells = 0

    def check(self) -> None:
        kind = self.word()
        name = self.word().upper()
        if kind.upper() != "DATASET":
            raise ValueError("no DATASET")
        if name not in ("UNSTRUCTURED_GRID", "POLYDATA"):
            raise MeshError(f"the file holds a data set {name}: save the cables as an unstructured grid")
        rows = 0
        while section := self.word(end=True).upper():
            if section in ("CELL_DATA", "POINT_DATA"):
                rows, expected = self.count(), self.cells if section == "CELL_DATA" else self.points
                if rows != expected:
                    raise MeshError(
                        f"the header promises {section} of {rows}, and there are {expected}: save the mesh again"
                    )
            else:
                self.section(section, rows)

    def section(self, section: str, rows: int) -> None:
        """Pass over a section; `rows` of the data of points or cells."""
        if section == "POINTS":
            self.points = self.count()
            self.skip("coordinates", 3 * self.points, self.word())
        elif section in _CELLS:
            self.cell_array(section)
        elif section == "CELL_TYPES":
            self.skip("cell types", self.count(), "int")
        elif section == "METADATA":
            self.metadata()
        elif section == "FIELD":
            self.word()
            self.fields(self.count())
        elif section == "SCALARS":
            _, kind = self.word(), self.word()
            given = self.word()
            columns = int(given) if given.isdigit() else 1
            if (given if columns == 1 and not given.isdigit() else self.word()).upper() != "LOOKUP_TABLE":
                raise ValueError("SCALARS without LOOKUP_TABLE")
            self.word()
            self.skip("values", rows * columns, kind)
        elif section in _ROWS:
            _, kind = self.word(), self.word()
            self.skip("values", rows * _ROWS[section], kind)
        elif section == "TEXTURE_COORDINATES":
            self.word()
            columns, kind = self.count(), self.word()
            self.skip("values", rows * columns, kind)
        elif section in ("COLOR_SCALARS", "LOOKUP_TABLE"):
            self.word()
            count = self.count()
            self.skip("colours", rows * count if section == "COLOR_SCALARS" else 4 * count, "unsigned_char")
        else:
            raise ValueError(f"unknown section {section}")

    def metadata(self) -> None:
        blank = _BLANK.search(self.data, self.place)
        self.place = blank.end() if blank else len(self.data)

    def word(self, *, end: bool = False) -> str:
        found = _WORD.match(self.data, self.place)
        if found is None:
            if end:
                return ""
            raise MeshError("the file is cut off: save the mesh again")
        self.place = found.end()
        return found[1].decode("latin-1")

    def count(self) -> int:
        text = self.word()
        if not text.isdigit():
            raise MeshError(f"the header has {text[:20]!r} where a count belongs: save the mesh again")
        return int(text)

    def room(self, what: str, count: int, kind: str, place: int) -> None:
        """Raise MeshError where `count` numbers do not fit in the rest of the file."""
        if kind.lower() not in _BYTES:
            raise MeshError(f"the type {kind[:20]!r} is unknown: save the mesh again")
        size = 2 if self.text else _BYTES[kind.lower()]
        if count * size - 1 > len(self.data) - place:
            raise MeshError(
                f"the header promises {count} {what}, more than the file holds: it is cut off or damaged, save the "
                "mesh again"
            )

    def skip(self, what: str, count: int, kind: str) -> None:
        self.numbers(what, count, kind, wanted=False)

    def numbers(self, what: str, count: int, kind: str, *, wanted: bool = True) -> IntArray:
        """The next numbers, whole where they are wanted."""
        self.room(what, count, kind, self.place)
        if not self.text:
            # the line of the header ends, then the bytes begin
            begin = self.data.find(b"\n", self.place) + 1
            size = (count + 7) // 8 if kind.lower() == "bit" else count * _BYTES[kind.lower()]
            if begin == 0 or begin + size > len(self.data):
                self.room(what, len(self.data), "double", self.place)
            self.place = begin + size
            if not wanted:
                return np.zeros(0, np.int64)
            return np.frombuffer(self.data, f">i{_BYTES[kind.lower()]}", count, begin).astype(np.int64)
        rest = self.data[self.place :].split(None, count)
        if len(rest) < count:
            raise MeshError(
                f"the header promises {count} {what} and the file has {len(rest)}: it is cut off, save the mesh again"
            )
        self.place = len(self.data) - len(rest[count]) if len(rest) > count else len(self.data)
        if not wanted:
            return np.zeros(0, np.int64)
        return np.array([int(each) for each in rest[:count]], dtype=np.int64)

    def cell_array(self, section: str) -> None:
        first, second = self.count(), self.count()
        begin = self.place
        if self.word(end=True).upper() == "OFFSETS":
            offsets = self.numbers("offsets", first, self.word())
            if self.word().upper() != "CONNECTIVITY":
                raise MeshError("the cells have no CONNECTIVITY: the file is damaged, save the mesh again")
            points = self.numbers("points of cells", second, self.word())
            if not self.new or (
                first and (offsets[0] != 0 or offsets[-1] != second or (np.diff(offsets) < 0).any())
            ):
                self.damaged(section)
            count = max(0, first - 1)
        else:
            self.place = begin
            values = self.numbers("numbers of cells", second, "int")
            place = count = 0
            marks = []
            listed = values.tolist()
            while place < second:
                marks.append(place)
                if listed[place] < 0:
                    self.damaged(section)
                place += listed[place] + 1
                count += 1
            if place != second or count != first or self.new:
                self.damaged(section)
            points = np.delete(values, marks)
        if len(points) and (points.min() < 0 or points.max() >= self.points):
            raise MeshError(
                f"a cell joins node {points.max() if points.min() >= 0 else points.min()}, but the file has "
                f"{self.points} nodes: save the mesh again"
            )
        self.cells += count

    def damaged(self, section: str) -> None:
        raise MeshError(
            f"the header promises more or other cells than the file holds under {section}: it is damaged, save the "
            "mesh again"
        )

    def fields(self, count: int) -> None:
        """Arrays of a FIELD."""
        for _ in range(count):
            if self.word().upper() == "METADATA":
                self.metadata()
                self.word()
            size = self.count() * self.count()
            kind = self.word()
            if kind.lower() == "string":
                self.strings(size)
            else:
                self.skip("values", size, kind)

    def strings(self, count: int) -> None:
        """Strings: a line each in text, otherwise their length in 1, 2, 4 or 8 bytes, and their bytes."""
        self.room("strings", count, "char", self.place)
        self.place = self.data.find(b"\n", self.place) + 1 or len(self.data)
        for _ in range(count):
            if self.place >= len(self.data):
                raise MeshError("the file is cut off: save the mesh again")
            if self.text:
                self.place = self.data.find(b"\n", self.place) + 1 or len(self.data)
                continue
            width = 8 >> (self.data[self.place] >> 6)
            head = int.from_bytes(self.data[self.place : self.place + width], "big")
            self.place += width + (head & ((1 << (8 * width - 2)) - 1))
