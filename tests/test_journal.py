"""Journals: rows on disk that a kill at any byte leaves usable."""

from pathlib import Path

import numpy as np
import pytest

from netdae.errors import InputError, RunError
from netdae.journal import Journal

WIDTH = 3
ROWS = np.random.default_rng(4).normal(size=(5, WIDTH))
ROWS[:, 0] = [0.0, 0.1, 0.1, 0.25, 0.3]


def journal_in(folder: Path, rows: np.ndarray = ROWS) -> Journal:
    journal = Journal(WIDTH, folder / "rows.journal")
    journal.clear()
    for row in rows:
        journal.append(row.tolist())
    return journal


def reopened(path: Path) -> Journal:
    journal = Journal(WIDTH, path)
    journal.reopen()
    return journal


def test_rows_come_back_to_the_last_bit_from_a_file_and_from_memory(tmp_path):
    memory = Journal(WIDTH)
    memory.append(ROWS)
    for journal in (journal_in(tmp_path), memory):
        assert len(journal) == 5
        np.testing.assert_array_equal(journal.rows(), ROWS)
        journal.close()
        np.testing.assert_array_equal(journal.rows(), ROWS)
    np.testing.assert_array_equal(reopened(tmp_path / "rows.journal").rows(), ROWS)


def test_file_cut_at_any_byte_keeps_its_whole_rows_and_takes_new_ones(tmp_path):
    journal = journal_in(tmp_path)
    journal.close()
    data = journal.path.read_bytes()
    head = len(data) - ROWS.nbytes
    for size in range(len(data) + 1):
        journal.path.write_bytes(data[:size])
        again = reopened(journal.path)
        whole = max(0, size - head) // (8 * WIDTH)
        np.testing.assert_array_equal(again.rows(), ROWS[:whole])
        again.append(ROWS[4])
        again.close()
        np.testing.assert_array_equal(reopened(journal.path).rows(), [*ROWS[:whole], ROWS[4]])


@pytest.mark.parametrize("on_disk", [True, False])
def test_rows_after_a_count_are_dropped(on_disk, tmp_path):
    journal = journal_in(tmp_path) if on_disk else Journal(WIDTH)
    if not on_disk:
        journal.append(ROWS)
    journal.keep(3)
    journal.append(ROWS[4])
    np.testing.assert_array_equal(journal.rows(), ROWS[[0, 1, 2, 4]])
    with pytest.raises(InputError, match="holds 4 rows, expected 5 at least: it is damaged"):
        journal.keep(5)


def test_filled_journal_goes_on_like_one_that_grew(tmp_path):
    grown = journal_in(tmp_path)
    filled = Journal(WIDTH, tmp_path / "filled.journal")
    filled.fill(ROWS)
    for journal in (grown, filled):
        journal.append(ROWS[0])
        journal.close()
    assert grown.path.read_bytes() == filled.path.read_bytes()
    filled.remove()
    filled.remove()
    assert [file.name for file in tmp_path.iterdir()] == ["rows.journal"]


def test_clearing_replaces_a_former_file(tmp_path):
    journal_in(tmp_path).close()
    journal = journal_in(tmp_path, ROWS[:0])
    assert len(journal) == 0
    assert journal.rows().shape == (0, WIDTH)


def test_many_rows_reach_the_file_before_a_flush_and_all_with_it(tmp_path):
    journal = journal_in(tmp_path, ROWS[:0])
    for number in range(60_000):
        journal.append((float(number), 0.0, 0.0))
    assert journal.path.stat().st_size > 8 * WIDTH * 40_000
    np.testing.assert_array_equal(journal.rows()[:, 0], np.arange(60_000))


def test_other_files_and_places_are_refused_in_one_line(tmp_path):
    journal = journal_in(tmp_path)
    journal.close()
    with pytest.raises(InputError, match="is not a journal of rows of 4 numbers"):
        Journal(4, journal.path).reopen()
    journal.path.write_bytes(b"time,mouth_area\n0.0,1.0\n")
    with pytest.raises(InputError, match="is not a journal of rows of 3 numbers"):
        reopened(journal.path)
    with pytest.raises(InputError, match="cannot be gone on from: No such file"):
        reopened(tmp_path / "none.journal")
    with pytest.raises(InputError, match=r"cannot be written: .*: choose another output folder"):
        journal_in(journal.path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the device that is always full is Linux's")
def test_full_disk_is_one_clear_error(tmp_path):
    journal = journal_in(tmp_path)
    journal.flush()
    journal._stream = open("/dev/full", "r+b", buffering=0)  # noqa: SIM115
    journal.append(ROWS[0])
    with pytest.raises(RunError, match=r"rows\.journal could not be written: No space left"):
        journal.flush()
