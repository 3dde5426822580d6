"""XDMF files, versions 2 and 3: one grid, or the first of a series in time.

Names of types are compared without regard to case, as programs write Polyline and PolyLine.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from math import prod
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from netdae.core.errors import MeshError
from netdae.mesh.findings import many
from netdae.mesh.vtu_counts import LARGEST

_TYPES = {
    name.lower(): kind for kind, names in meshio.xdmf.common.meshio_to_xdmf_type.items() for name in names
} | {"edge": "line", "edge_3": "line3", "polygon": "polygon"}
_COUNTED = {"polyvertex": 1, "polyline": 2}  # types whose cells have as many nodes as NodesPerElement says
_KINDS = {"int": "i", "uint": "u", "float": "f", "char": "i", "uchar": "u"}


def read_xdmf(file: Path) -> tuple[Any, tuple[str, ...]]:
    """Mesh of meshio, and what its author should know.

    Raises MeshError for features that are not read, by name; other errors where the file is damaged.
    """
    root = ET.parse(file).getroot()
    if root.tag != "Xdmf":
        raise ValueError("no Xdmf")
    grids = list(_grids(root))
    if not grids:
        raise MeshError("the file has no grid with a Topology or a Geometry: save the mesh again")
    steps = [each for each in root.iter("Grid") if each.get("CollectionType", "").lower() == "temporal"]
    findings: tuple[str, ...] = ()
    if len(grids) > 1 or steps:
        if not steps:
            raise MeshError(f"the file has {len(grids)} grids, which is not read: save one grid")
        findings = (f"a series in time of {many(len(list(steps[0])), 'grid')}, of which the first is read",)
    return _Reader(file, root).mesh(grids[0]), findings


def _grids(root: ET.Element) -> Iterator[ET.Element]:
    for grid in root.iter("Grid"):
        if grid.find("Topology") is not None or grid.find("Geometry") is not None:
            yield grid


class _Reader:
    def __init__(self, file: Path, root: ET.Element) -> None:
        self.file, self.root = file, root

    def mesh(self, grid: ET.Element) -> Any:
        points = self.points(self.known(grid.find("Geometry")))
        cells = self.cells(self.known(grid.find("Topology")))
        counts = {"node": len(points), "cell": sum(len(block.data) for block in cells)}
        data: dict[str, dict[str, NDArray[Any]]] = {"node": {}, "cell": {}}
        for attribute in grid.iter("Attribute"):
            centre = attribute.get("Center", "Node").lower()
            if centre not in data:
                continue
            name, values = attribute.get("Name", ""), self.item(attribute)
            if values.ndim > 1 and values.shape[1:] == (1,):
                values = values[:, 0]
            if len(values) != counts[centre]:
                raise MeshError(
                    f"the attribute {name!r} has {len(values)} values for {many(counts[centre], centre)}: the file is "
                    "damaged, save the mesh again"
                )
            data[centre][name] = values
        ends = np.cumsum([len(block.data) for block in cells])[:-1]
        return meshio.Mesh(
            points,
            cells,
            point_data=data["node"],
            cell_data={name: np.split(values, ends) for name, values in data["cell"].items()},
        )

    def known(self, element: ET.Element | None) -> ET.Element:
        """The element, or the one that its Reference names."""
        if element is None:
            raise MeshError("the grid has no Topology or no Geometry: save the mesh again")
        reference = element.get("Reference")
        if reference is None:
            return element
        path = (element.text or "" if reference == "XML" else reference).strip()
        found = self.root.find("./" + path.removeprefix("/Xdmf").lstrip("/"))
        if found is None:
            raise MeshError(f"the reference {path[:60]!r} is not read: save the mesh without references")
        return self.known(found)

    def points(self, geometry: ET.Element) -> NDArray[Any]:
        kind = (geometry.get("GeometryType") or geometry.get("Type") or "XYZ").upper()
        items = [self.item_of(each) for each in geometry.findall("DataItem")]
        if kind in ("X_Y", "X_Y_Z"):
            return np.column_stack([each.reshape(-1) for each in items])
        if kind not in ("XY", "XYZ"):
            raise MeshError(f"a geometry of type {kind} is not read: save the nodes as XYZ")
        return items[0].reshape(-1, len(kind))

    def cells(self, topology: ET.Element) -> list[Any]:
        kind = (topology.get("TopologyType") or topology.get("Type") or "").lower()
        base = int(topology.get("BaseOffset", "0"))
        values = self.item(topology)
        if kind == "mixed":
            if base:
                raise MeshError("BaseOffset of a Mixed topology is not read: save the cells of one type")
            return list(meshio.xdmf.common.translate_mixed_cells(values.reshape(-1)))
        if kind not in _TYPES:
            raise MeshError(f"a topology of type {kind or 'none'} is not read: save the cables as Polyline")
        if values.ndim != 2:
            nodes = topology.get("NodesPerElement") or _COUNTED.get(kind)
            count = topology.get("NumberOfElements")
            if nodes is None and count is None:
                raise MeshError(
                    "the cells have neither NodesPerElement nor two dimensions: save the mesh again"
                )
            values = values.reshape(-1, int(nodes)) if nodes else values.reshape(int(count or 0), -1)
        promised = topology.get("NumberOfElements") or topology.get("Dimensions")
        if promised and prod(map(int, promised.split())) != len(values):
            raise MeshError(
                f"the header promises {promised} cells and the file has {len(values)}: save the mesh again"
            )
        return [meshio.CellBlock(_TYPES[kind], values - base)]

    def item(self, element: ET.Element) -> NDArray[Any]:
        found = element.find("DataItem")
        if found is None:
            raise MeshError(f"a {element.tag} has no DataItem: the file is damaged, save the mesh again")
        return self.item_of(found)

    def item_of(self, item: ET.Element) -> NDArray[Any]:
        item = self.known(item)
        if item.get("ItemType", "Uniform").lower() != "uniform":
            raise MeshError(f"DataItem of type {item.get('ItemType')} is not read: save the data as Uniform")
        shape = [int(each) for each in (item.get("Dimensions") or "").split()]
        kind = (item.get("NumberType") or item.get("DataType") or "Float").lower()
        size = {"char": "1", "uchar": "1"}.get(kind) or item.get("Precision", "4")
        if kind not in _KINDS or size not in ("1", "2", "4", "8"):
            raise MeshError(
                f"data of type {kind} and precision {size} are not read: save them as Float or Int"
            )
        dtype = np.dtype(f"{_KINDS[kind]}{size}")
        if prod(shape) * dtype.itemsize > LARGEST:
            raise MeshError(
                f"data of {shape} would take over {LARGEST >> 30} GiB of memory: take a coarser mesh"
            )
        layout, text = item.get("Format", "XML").upper(), (item.text or "").strip()
        if layout == "XML":
            words = text.split()
            # a file states less than double precision for text that has it
            values = np.array(words, dtype="S").astype(np.float64 if dtype.kind == "f" else dtype)
        elif layout in ("HDF", "HDF5"):
            values = self.from_hdf(text)
        elif layout == "BINARY":
            big = item.get("Endian", "Native").lower() == "big"
            with (self.file.parent / text).open("rb") as stream:
                stream.seek(int(item.get("Seek", "0")))
                values = np.frombuffer(
                    stream.read(prod(shape) * dtype.itemsize), dtype.newbyteorder(">" if big else "<")
                )
        else:
            raise MeshError(f"data of format {layout} are not read: save them as XML or HDF")
        if values.size != prod(shape):
            raise MeshError(
                f"the header promises {prod(shape)} values and there are {values.size}: it is cut off or damaged, "
                "save the mesh again"
            )
        return values.reshape(shape).astype(values.dtype.newbyteorder("="))

    def from_hdf(self, text: str) -> NDArray[Any]:
        import h5py

        name, _, path = text.rpartition(":")
        with h5py.File(self.file.parent / name, "r") as store:
            found = store[path]
            if found.nbytes > LARGEST:
                raise MeshError(f"{path} would take over {LARGEST >> 30} GiB of memory: take a coarser mesh")
            return np.asarray(found[()])
