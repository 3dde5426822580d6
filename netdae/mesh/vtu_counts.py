"""What the headers of a .vtu or .vtp file promise against what its arrays hold.

An array is text, or bytes in base64 or raw, in place or appended, whole or compressed by blocks. Bytes begin with their
number, or with the number of blocks, the size of a block, the size of the last and the compressed sizes. VTK
and meshio fill up what is missing, or take memory for what is promised; hence these checks come first.
"""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator

import numpy as np

from netdae.core.errors import MeshError

LARGEST = 2 << 30
"""Memory that the arrays of a file may take, bytes: 2 GiB."""

_APPENDED = re.compile(rb"<AppendedData[^>]*>\s*_")
_SIZES = {"Int8": 1, "UInt8": 1, "Int16": 2, "UInt16": 2, "Int32": 4, "UInt32": 4, "Int64": 8, "UInt64": 8}
_SIZES |= {"Float32": 4, "Float64": 8, "String": 1}
_KNOWN = ("vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor")


def check_xml(data: bytes) -> None:
    """Raise MeshError for a file whose arrays are shorter than promised; ET.ParseError for one that is no XML."""
    appended = _APPENDED.search(data)
    start = data.rfind(b"<", 0, appended.end()) if appended else 0
    root = ET.fromstring(data[:start] + b"</VTKFile>" if appended else data)
    if root.tag != "VTKFile":
        raise MeshError("the file is no VTKFile: save the mesh again")
    raw = appended is not None and b"raw" in appended[0]
    file = _File(root, data, appended.end() if appended else 0, raw)
    total = 0
    for piece in root.iter("Piece"):
        for array, count in _arrays_of(piece):
            total += file.check(array, count)
            if total > LARGEST:
                raise MeshError(
                    f"its arrays would take over {LARGEST >> 30} GiB of memory: it is damaged, or take a coarser mesh"
                )


def _count(piece: ET.Element, name: str) -> int:
    text = piece.get(name, "0").strip() or "0"
    if not text.isdigit():
        raise MeshError(f"{name} is {text[:20]!r}, expected a count: save the mesh again")
    return int(text)


def _arrays_of(piece: ET.Element) -> Iterator[tuple[ET.Element, int | None]]:
    """Arrays of a piece and the number of rows that its header promises, None where it states none."""
    points = _count(piece, "NumberOfPoints")
    kinds = {
        "Verts": "NumberOfVerts",
        "Lines": "NumberOfLines",
        "Polys": "NumberOfPolys",
        "Strips": "NumberOfStrips",
    }
    cells = _count(piece, "NumberOfCells") + sum(_count(piece, name) for name in kinds.values())
    rows = {"Points": points, "PointData": points, "CellData": cells, "Cells": cells}
    for group in piece:
        count = _count(piece, kinds[group.tag]) if group.tag in kinds else rows.get(group.tag)
        if count is None:
            continue
        for array in group:
            if array.tag not in ("DataArray", "Array"):
                continue
            listed = group.tag in ("Cells", *kinds) and array.get("Name") not in ("offsets", "types")
            yield array, None if listed or array.get("type") == "String" else count


class _File:
    """The file that an array is in: its byte order, the type of its headers, and its appended bytes."""

    def __init__(self, root: ET.Element, data: bytes, appended: int, raw: bool) -> None:
        order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.header = np.dtype(f"{order}u{8 if root.get('header_type') == 'UInt64' else 4}")
        self.compressed = root.get("compressor") in _KNOWN
        self.data, self.appended, self.raw = data, appended, raw

    def check(self, array: ET.Element, rows: int | None) -> int:
        """Bytes that an array takes; raises MeshError where they are not those of `rows` rows."""
        name = array.get("Name", "Points")
        size = _SIZES.get(array.get("type", ""))
        if size is None:
            raise MeshError(f"the array {name!r} has the type {array.get('type')!r}: save the mesh again")
        columns = array.get("NumberOfComponents", "1").strip() or "1"
        if not columns.isdigit():
            raise MeshError(f"the array {name!r} has {columns[:20]!r} components: save the mesh again")
        expected = None if rows is None else rows * max(1, int(columns)) * size
        if array.get("format", "ascii") == "ascii":
            found = len((array.text or "").split()) * size
        else:
            found = self.bytes_of(array, name, expected)
        if expected is not None and found != expected:
            raise MeshError(
                f"the header promises {rows} rows of {name!r}, {expected} bytes, and the file has {found}: it is cut "
                "off or damaged, save the mesh again"
            )
        return found

    def bytes_of(self, array: ET.Element, name: str, expected: int | None) -> int:
        if array.get("format") == "appended":
            offset = array.get("offset", "").strip()
            place = self.appended + int(offset) if offset.isdigit() else len(self.data)
            if not self.appended or place >= len(self.data):
                return self.empty(name, expected)
            rest, raw = self.data[place:], self.raw
        else:
            rest, raw = "".join((array.text or "").split()).encode("ascii", "replace"), False
            if not rest:
                return self.empty(name, expected)
        width = self.header.itemsize
        if not self.compressed:
            (count,) = self.head(rest, 1, raw, name)
            held = len(rest) - width if raw else _unpacked(rest) - width
            if count > held:
                raise self.short(name, count, held)
            return int(count)
        blocks, block, last = self.head(rest, 3, raw, name)
        if blocks * width > len(rest):
            raise self.short(name, blocks * width, len(rest))
        sizes = self.head(rest, 3 + blocks, raw, name)[3:]
        used = width * (3 + blocks)
        held = len(rest) - used if raw else _unpacked(rest[4 * -(-used // 3) :])
        if sum(sizes) > held:
            raise self.short(name, sum(sizes), held)
        return int(block * (blocks - 1) + last if last else block * blocks)

    def head(self, rest: bytes, count: int, raw: bool, name: str) -> list[int]:
        """The leading numbers of an array."""
        size = self.header.itemsize * count
        first = rest[:size] if raw else _decoded(rest[: 4 * -(-size // 3)])
        if len(first) < size:
            raise self.short(name, size, len(first))
        return np.frombuffer(first, self.header, count).tolist()

    def empty(self, name: str, expected: int | None) -> int:
        if expected:
            raise self.short(name, expected, 0)
        return 0

    def short(self, name: str, promised: int, found: int) -> MeshError:
        return MeshError(
            f"the array {name!r} promises {promised} bytes and the file has {found}: it is cut off or damaged, save "
            "the mesh again"
        )


def _decoded(text: bytes) -> bytes:
    try:
        return base64.b64decode(text, validate=True)
    except ValueError:
        return b""


def _unpacked(text: bytes) -> int:
    """Bytes that base64 holds up to its end or the next of several pieces."""
    end = re.search(rb"[^A-Za-z0-9+/]", text)
    length = end.start() if end else len(text)
    return length * 3 // 4
