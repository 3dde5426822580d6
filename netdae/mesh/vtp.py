"""Nets written as .vtp, the poly data of VTK and pyvista."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from netdae.core.arrays import FloatArray, IntArray
from netdae.model.net import CableNet

_TYPES = {"float64": "Float64", "int64": "Int64", "uint8": "UInt8"}


def write_vtp(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    """Write a net with its groups, 0 or 1, and the given numbers of its cables."""
    offsets = 2 * np.arange(1, net.cable_count + 1)
    cells: dict[str, NDArray[Any]] = {**_flags(net.cable_groups, net.cable_count), **numbers}
    points = _flags(net.node_groups, net.node_count)
    text = [
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        f'<PolyData><Piece NumberOfPoints="{net.node_count}" NumberOfLines="{net.cable_count}">',
        "<PointData>",
        *(_array(name, values) for name, values in points.items()),
        "</PointData><CellData>",
        *(_array(name, values) for name, values in cells.items()),
        "</CellData><Points>",
        _array("Points", net.nodes),
        "</Points><Lines>",
        _array("connectivity", net.cables.reshape(-1)),
        _array("offsets", offsets),
        "</Lines></Piece></PolyData></VTKFile>",
    ]
    path.write_text("\n".join(text) + "\n", encoding="utf-8", newline="\n")


def _flags(groups: Mapping[str, IntArray], count: int) -> dict[str, NDArray[np.uint8]]:
    named = {name: member for name, member in groups.items() if name != "all"}
    return {name: np.isin(np.arange(count), member).astype(np.uint8) for name, member in named.items()}


def _array(name: str, values: NDArray[Any]) -> str:
    data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    packed = base64.b64encode(len(data).to_bytes(8, "little") + data).decode()
    columns = values.shape[1] if values.ndim > 1 else 1
    return (
        f'<DataArray type="{_TYPES[values.dtype.name]}" Name={quoteattr(name)} NumberOfComponents="{columns}" '
        f'format="binary">{packed}</DataArray>'
    )
