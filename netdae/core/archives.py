"""Archives of arrays (.npz), checked before their arrays take memory."""

from __future__ import annotations

import zipfile
from math import prod
from pathlib import Path

from numpy.lib import format as npy

LARGEST = 2 << 30
"""Memory that the arrays of an archive may take, bytes: 2 GiB."""


def check_archive(source: Path) -> None:
    """Raise ValueError for an archive whose arrays take over 2 GiB, or promise more than they hold.

    A compressed file of some kB can hold many GiB, and a header can promise any size.
    Raises also OSError and zipfile.BadZipFile.
    """
    total = 0
    with zipfile.ZipFile(source) as archive:
        for member in archive.infolist():
            total += member.file_size
            if total > LARGEST:
                raise ValueError(f"its arrays would take over {LARGEST >> 30} GiB of memory")
            with archive.open(member) as stream:
                version = npy.read_magic(stream)
                read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
                shape, _, dtype = read(stream)
            if prod(shape) * dtype.itemsize > member.file_size:
                raise ValueError(f"{member.filename} promises an array of {shape} and is shorter")
