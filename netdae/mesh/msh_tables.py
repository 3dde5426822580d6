"""Sections of Gmsh's MSH files, versions 2.2 and 4.1, in text and binary, as arrays.

What a table promises is compared with what it holds. Sections of other programs are passed over.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import MeshError

LINE, VERTEX = 1, 15  # element types of MSH
NODES = {
    1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 13: 18, 14: 14, 15: 1, 16: 8,
    17: 20, 18: 15, 19: 13, 20: 9, 21: 10, 22: 12, 23: 15, 24: 15, 25: 21, 26: 4, 27: 5, 28: 6, 29: 20, 30: 35,
    31: 56, 36: 16, 37: 25, 38: 36, 92: 64, 93: 125,
}  # fmt: skip
"""Nodes of the element types."""

_OPEN = re.compile(rb"^\$(?!End)([^\r\n]*?)[ \t]*\r?\n", re.MULTILINE)


@dataclass(frozen=True)
class Sections:
    """Sections by name, those of one name in file order; `text`: no binary; `size`: bytes of a count."""

    version: str
    text: bool
    size: int
    tables: Mapping[str, list[bytes]]

    def reader(self, table: bytes) -> Numbers:
        """Reader of a table's numbers."""
        return Numbers(table, self.text, self.size)


class Elements(NamedTuple):
    """Elements of one type: their numbers, the tags that groups refer to, and their nodes' numbers (c, k)."""

    kind: int
    numbers: IntArray
    tags: IntArray
    nodes: IntArray


def sections_of(data: bytes, version: str, text: bool, size: int) -> Sections:
    """Cut a file into its sections; raises MeshError for one of Gmsh's that does not end."""
    tables: dict[str, list[bytes]] = {}
    place = 0
    while start := _OPEN.search(data, place):
        name = start[1]
        end = re.compile(rb"\r?\n?\$End[ \t]*" + re.escape(name) + rb"[ \t]*(\r?\n|$)").search(
            data, start.end()
        )
        if end is None:
            known = name in (
                b"PhysicalNames",
                b"Entities",
                b"Nodes",
                b"Elements",
                b"ElementData",
                b"NodeData",
            )
            if known:
                raise MeshError(
                    f"the file is cut off, a section of it does not end (${name.decode(errors='replace')[:40]}): "
                    "save the mesh again"
                )
            place = start.end()
            continue
        tables.setdefault(name.decode(errors="replace"), []).append(data[start.end() : end.start()])
        place = end.end()
    return Sections(version, text, size, tables)


def nodes_of(sections: Sections) -> tuple[IntArray, FloatArray]:
    """Numbers (p,) and places (p, 3) of the nodes; parameters of nodes on curves and surfaces are passed over."""
    numbers, places = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for table in sections.tables.get("Nodes", []):
        read = sections.reader(table)
        if sections.version == "2.2":
            count = read.line_count()
            found = read.rows(count, ("i4", "f8", "f8", "f8"), "nodes")
            numbers.append(found[:, 0].astype(np.int64))
            places.append(found[:, 1:])
        else:
            blocks, promised = read.sizes(4)[:2]
            for _ in range(blocks):
                dimension, _, parametric = read.ints(3)
                (count,) = read.sizes(1)
                numbers.append(np.array(read.sizes(count), dtype=np.int64))
                width = 3 + (dimension if parametric else 0)
                places.append(read.floats(count * width).reshape(count, width)[:, :3])
            _same(promised, sum(map(len, numbers)), "nodes")
        read.end("nodes")
    return np.concatenate(numbers), np.concatenate(places)


def elements_of(sections: Sections) -> list[Elements]:
    """Elements of each run of one type."""
    found: list[Elements] = []
    for table in sections.tables.get("Elements", []):
        read = sections.reader(table)
        if sections.version == "2.2":
            count = read.line_count()
            made = list(_listed(read, count) if sections.text else _packed(read, count))
            _same(count, sum(len(each.numbers) for each in made), "elements")
        else:
            blocks, count = read.sizes(4)[:2]
            made = []
            for _ in range(blocks):
                _, tag, kind = read.ints(3)
                (size,) = read.sizes(1)
                width = 1 + _nodes_of(kind)
                rows = np.array(read.sizes(size * width), dtype=np.int64).reshape(size, width)
                made.append(Elements(kind, rows[:, 0], np.full(size, tag), rows[:, 1:]))
            _same(count, sum(len(each.numbers) for each in made), "elements")
            read.end("elements")
        found += made
    return found


def data_of(sections: Sections, section: str, numbers: IntArray) -> dict[str, FloatArray]:
    """Name to values of ElementData or NodeData, in the order of `numbers`, NaN where an element or node has none."""
    result: dict[str, FloatArray] = {}
    order = np.argsort(numbers, kind="stable")
    for table in sections.tables.get(section, []):
        read = sections.reader(table)
        strings = read.lines(read.line_count())
        read.lines(read.line_count())
        tags = [int(line) for line in read.lines(read.line_count())]
        if not strings or len(tags) < 3:
            raise MeshError(f"${section} has no name or too few integer tags: save the mesh again")
        columns, count = tags[1:3]
        rows = read.rows(count, ("i4", *("f8",) * columns), f"rows of ${section}")
        read.end(f"rows of ${section}")
        name = strings[0].decode(errors="replace").strip().strip('"')
        place = np.searchsorted(numbers[order], rows[:, 0])
        inside = (place < len(numbers)) & (numbers[order][np.minimum(place, len(numbers) - 1)] == rows[:, 0])
        if not inside.all():
            raise MeshError(
                f"${section} {name!r} is for {rows[~inside][0, 0]:g}, but the file has no such number: save the mesh "
                "again"
            )
        values = result.setdefault(name, np.full((len(numbers), columns), np.nan))
        if values.shape[1] == columns:
            values[order[place]] = rows[:, 1:]
    return {name: values[:, 0] if values.shape[1] == 1 else values for name, values in result.items()}


def _listed(read: Numbers, count: int) -> Iterator[Elements]:
    """Elements of version 2.2 in text: number, type, tags with their count, nodes."""
    rows = [[int(word) for word in line.split()] for line in read.lines(None)]
    _same(count, len(rows), "elements")
    start = 0
    while start < len(rows):
        stop = start
        kind = rows[start][1] if len(rows[start]) > 2 else 0
        while stop < len(rows) and rows[stop][1:2] == [kind]:
            stop += 1
        run = rows[start : max(stop, start + 1)]
        width = _nodes_of(kind)
        for row in run:
            if len(row) != 3 + row[2] + width:
                raise MeshError(
                    f"element {row[0]} of the file has {len(row)} numbers, expected {3 + row[2] + width}: the file is "
                    "cut off or damaged, save the mesh again"
                )
        table = np.array(
            [[row[0], row[3] if row[2] else 0, *row[3 + row[2] :]] for row in run], dtype=np.int64
        )
        yield Elements(kind, table[:, 0], table[:, 1], table[:, 2:])
        start = stop


def _packed(read: Numbers, count: int) -> Iterator[Elements]:
    """Elements of version 2.2 in binary: blocks of a type."""
    done = 0
    while done < count:
        kind, size, tags = read.ints(3)
        width = 1 + tags + _nodes_of(kind)
        if size < 1 or tags < 0:
            raise MeshError("a block of elements has no size: the file is damaged, save the mesh again")
        rows = np.array(read.ints(size * width), dtype=np.int64).reshape(size, width)
        yield Elements(
            kind, rows[:, 0], rows[:, 1] if tags else np.zeros(size, np.int64), rows[:, 1 + tags :]
        )
        done += size


def _nodes_of(kind: int) -> int:
    if kind not in NODES:
        raise MeshError(f"elements of MSH type {kind} are not read: save the cables as lines")
    return NODES[kind]


def _same(promised: int, found: int, what: str) -> None:
    if promised != found:
        raise MeshError(
            f"the header promises {promised} {what} and the file has {found}: it is cut off or damaged, save the mesh "
            "again"
        )


class Numbers:
    """A place among the numbers of a table; raises MeshError where they end early."""

    def __init__(self, table: bytes, text: bool, size: int) -> None:
        self._table, self._text, self._place = table, text, 0
        self._size = np.dtype(f"u{size}")
        self._words: list[bytes] | None = None
        self._word = 0

    def ints(self, count: int) -> list[int]:
        """Numbers of four bytes."""
        return self._take(count, np.dtype("i4")).tolist()

    def sizes(self, count: int) -> list[int]:
        """Counts and numbers of nodes and elements."""
        return self._take(count, self._size).tolist()

    def floats(self, count: int) -> FloatArray:
        """Coordinates."""
        return self._take(count, np.dtype("f8")).astype(np.float64)

    def line_count(self) -> int:
        """A count that stands on a line of its own, also in a binary file."""
        text = self.lines(1)[0].strip()
        if not text.isdigit() or len(text) > 12:
            raise MeshError(
                "a count is missing where a section begins: the file is damaged, save the mesh again"
            )
        return int(text)

    def lines(self, count: int | None) -> list[bytes]:
        """The next lines that are not empty, all where `count` is None."""
        found: list[bytes] = []
        while self._place < len(self._table) and (count is None or len(found) < count):
            end = self._table.find(b"\n", self._place)
            end = len(self._table) if end < 0 else end
            line = self._table[self._place : end].strip()
            self._place = end + 1
            if line:
                found.append(line)
        if count is not None and len(found) < count:
            raise MeshError("a section is cut off: save the mesh again")
        return found

    def rows(self, count: int, kinds: tuple[str, ...], what: str) -> FloatArray:
        """`count` rows of numbers, one of each kind."""
        if self._text:
            rows = [line.split() for line in self.lines(None)]
            _same(count, len(rows), what)
            if any(len(row) != len(kinds) for row in rows):
                raise MeshError(f"a line among the {what} has not {len(kinds)} numbers: save the mesh again")
            return np.array(rows, dtype="S").astype(np.float64).reshape(count, len(kinds))
        kind = np.dtype([(f"f{k}", each) for k, each in enumerate(kinds)])
        found = self._take(count, kind)
        return np.column_stack([found[name].astype(np.float64) for name in kind.names or ()])

    def end(self, what: str) -> None:
        """Raise MeshError where a table in text goes on."""
        rest = self._words[self._word :] if self._words is not None else self._table[self._place :].strip()
        if self._text and rest:
            raise MeshError(
                f"there are more {what} than the header promises: the file is damaged, save it again"
            )

    def _take(self, count: int, kind: np.dtype[Any]) -> NDArray[Any]:
        if count < 0:
            raise MeshError("a section promises less than nothing: the file is damaged, save the mesh again")
        if self._text:
            if self._words is None:
                self._words = self._table.split()
            words = self._words[self._word : self._word + count]
            self._word += len(words)
            if len(words) == count:
                numbers = np.array(words or [b"0"], dtype="S")
                return numbers.astype(np.float64 if kind.kind == "f" else np.int64)[:count]
        elif count * kind.itemsize <= len(self._table) - self._place:
            values = np.frombuffer(self._table, kind, count, self._place)
            self._place += values.nbytes
            return values
        raise MeshError("a section promises more numbers than it holds: it is cut off, save the mesh again")
