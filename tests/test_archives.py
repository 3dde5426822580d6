"""Archives of arrays that would fill the memory are refused before they do."""

import io
import zipfile

import numpy as np
import pytest

from netdae.core.archives import check_archive
from netdae.core.errors import InputError
from netdae.model.state import Trajectory
from netdae.output.checkpoint import read_checkpoint


def header(shape):
    content = io.BytesIO()
    np.lib.format.write_array_header_1_0(content, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return content.getvalue()


def write_bomb(file, size):
    """An archive of some MB whose only array has `size` bytes of zeros."""
    zeros = bytes(1 << 20)
    with (
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("x.npy", "w", force_zip64=True) as stream,
    ):
        stream.write(header((size // 8,)))
        for _ in range(size >> 20):
            stream.write(zeros)


def test_small_files_of_large_arrays_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("netdae.core.archives.LARGEST", 32 << 20)  # as 2 GiB take 5 s to write
    file = tmp_path / "checkpoint.npz"
    write_bomb(file, 33 << 20)
    assert file.stat().st_size < 1 << 20
    for read in (read_checkpoint, Trajectory.load):
        with pytest.raises(InputError, match="arrays would take over"):
            read(file)


def test_header_that_promises_more_than_is_there_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("x.npy", header((10**12,)) + bytes(80))
    with pytest.raises(ValueError, match=r"x\.npy promises an array of \(1000000000000,\) and is shorter"):
        check_archive(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", x=np.zeros((3, 4)), name=np.array("text"))
    check_archive(tmp_path / "b.npz")
