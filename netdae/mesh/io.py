"""Nets from mesh files and back: Gmsh .msh, VTK .vtu, .vtp and .vtk, .xdmf, Abaqus .inp, .obj; and from CSV tables.

Physical groups, node and element sets, and integer data (everything that is not 0) are groups by their name:
of nodes where they hold points, of cables where they hold lines. Cell data `diameter`, `area`,
`youngs_modulus`, `density`, `prestress` and `rest_length` are numbers of the cables, in SI units.
"""

from __future__ import annotations

import contextlib
import logging
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from netdae.core.errors import InputError, MeshError
from netdae.core.files import no_file, reason_of, shown
from netdae.mesh.findings import difference_of
from netdae.mesh.formats import first_line, raw_mesh_of, write_mesh
from netdae.mesh.net import net_of
from netdae.mesh.weld import welded
from netdae.model.net import CableNet

log = logging.getLogger(__name__)

SUFFIXES = (".vtu", ".vtp", ".vtk", ".msh", ".xdmf", ".inp", ".obj")
"""Suffixes of the files that are read and written."""

READ_ONLY = (".csv",)
"""Suffixes of the files that are read alone."""


_LFS = b"version https://git-lfs"


@dataclass(frozen=True, eq=False)
class Description:
    """What is in a mesh file.

    net : the net that is made of it
    findings : what its author should know, a sentence each
    unused_data : names of data that netdae has no use for
    """

    net: CableNet
    findings: tuple[str, ...]
    unused_data: tuple[str, ...]


def read_net(
    path: str | os.PathLike[str], *, surface_edges: bool = False, merge: float | None = None
) -> CableNet:
    """Read a net from a mesh file; what its author should know goes to the log as warnings.

    Lines are cables; poly lines and quadratic lines are split at their nodes. With `surface_edges` the edges
    of surface cells are cables as well, in the groups border and inner. Nodes at most `merge` m apart are joined.
    Raises MeshError, one line with the file's name, for a file that is not a net.
    """
    found = describe(path, surface_edges=surface_edges, merge=merge)
    for finding in found.findings:
        log.warning("%s: %s", path, finding)
    return found.net


def describe(
    path: str | os.PathLike[str], *, surface_edges: bool = False, merge: float | None = None
) -> Description:
    """Net, findings and unused data of a mesh file, see `read_net`."""
    file = Path(path)
    _check_file(file)
    try:
        raw = raw_mesh_of(file)
        if merge is not None:
            raw = welded(raw, merge)
        net, findings = net_of(raw, surface_edges=surface_edges)
    except InputError as error:
        raise MeshError(f"{path}: {error}") from error
    return Description(net, findings, raw.unused_data)


def write_net(net: CableNet, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
    """Write a net with its groups and data; the suffix determines the format.

    Its folder is created. The file gets its name only when reading it back has given the same net.
    Raises MeshError for a file that exists, unless `overwrite`, and for a net that the format cannot hold.
    """
    file = Path(path)
    if trouble := no_file(file):
        raise MeshError(f"{shown(file)}: {trouble}")
    suffix = _suffix_of(file)
    if file.is_dir():
        raise MeshError(f"{path}: this is a folder: give the name of a file")
    if file.exists() and not overwrite:
        raise MeshError(
            f"{path}: the file exists: choose another name, or replace it by overwrite (--overwrite)"
        )
    numbers = dict(net.cable_data)
    if not np.array_equal(np.linalg.norm(net.spans, axis=1), net.rest_length):
        numbers["rest_length"] = net.rest_length
    temporary = file.with_name(f".{file.stem}.{os.getpid()}.part{suffix}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_mesh(temporary, net, numbers)
        difference = difference_of(net, describe(temporary).net)
        if difference:
            raise MeshError(f"reading it back gives {difference}: choose another ending or change the net")
        temporary.replace(file)
    except OSError as error:
        raise MeshError(
            f"{path}: the file cannot be written: {reason_of(error)}: choose another place"
        ) from error
    except Exception as error:
        reason = first_line(error).removeprefix(f"{temporary}: ")
        raise MeshError(f"{path}: a {suffix} file cannot hold this net: {reason}") from error
    finally:
        with contextlib.suppress(OSError):  # it does not exist, or this folder is read-only
            temporary.unlink()


def _suffix_of(file: Path, *, reading: bool = False) -> str:
    suffix = file.suffix.lower()
    if suffix not in (*SUFFIXES, *(READ_ONLY if reading else ())):
        found = f"the ending {file.suffix!r} is unknown" if suffix else "the name has no ending"
        raise MeshError(
            f"{file}: {found}: netdae reads and writes {', '.join(SUFFIXES)}, and reads {', '.join(READ_ONLY)}"
        )
    return suffix


def _check_file(file: Path) -> None:
    if trouble := no_file(file):
        raise MeshError(f"{shown(file)}: {trouble}")
    if file.is_dir():
        raise MeshError(f"{file}: this is a folder: give the name of a mesh file")
    if not file.exists():
        raise MeshError(f"{file}: there is no such file: check the name and the folder")
    _suffix_of(file, reading=True)
    if file.stat().st_size == 0:
        raise MeshError(f"{file}: the file is empty: write the mesh again")
    with contextlib.suppress(OSError), file.open("rb") as stream:  # the reader says what is wrong
        pointer = stream.read(len(_LFS)) == _LFS
        if pointer:
            raise MeshError(f"{file}: this is a pointer of Git LFS, not the mesh: fetch it by git lfs pull")
