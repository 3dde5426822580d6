"""Journals: rows on disk that a kill at any byte leaves usable."""

from pathlib import Path

import numpy as np
import pytest

from netdae.core.errors import InputError, RunError
from netdae.output.step_log import StepLog

WIDTH = 3
ROWS = np.random.default_rng(4).normal(size=(5, WIDTH))
ROWS[:, 0] = [0.0, 0.1, 0.1, 0.25, 0.3]


def journal_in(folder: Path, rows: np.ndarray = ROWS) -> StepLog:
    log = StepLog(WIDTH, folder / "rows.log")
    log.clear()
    for row in rows:
        log.append(row.tolist())
    return log


def reopened(path: Path) -> StepLog:
    log = StepLog(WIDTH, path)
    log.reopen()
    return log


def test_rows_come_back_to_the_last_bit_from_a_file_and_from_memory(tmp_path):
    memory = StepLog(WIDTH)
    memory.append(ROWS)
    for log in (journal_in(tmp_path), memory):
        assert len(log) == 5
        np.testing.assert_array_equal(log.rows(), ROWS)
        log.close()
        np.testing.assert_array_equal(log.rows(), ROWS)
    np.testing.assert_array_equal(reopened(tmp_path / "rows.log").rows(), ROWS)


def test_file_cut_at_any_byte_keeps_its_whole_rows_and_takes_new_ones(tmp_path):
    log = journal_in(tmp_path)
    log.close()
    data = log.path.read_bytes()
    head = len(data) - ROWS.nbytes
    for size in range(len(data) + 1):
        log.path.write_bytes(data[:size])
        again = reopened(log.path)
        whole = max(0, size - head) // (8 * WIDTH)
        np.testing.assert_array_equal(again.rows(), ROWS[:whole])
        again.append(ROWS[4])
        again.close()
        np.testing.assert_array_equal(reopened(log.path).rows(), [*ROWS[:whole], ROWS[4]])


@pytest.mark.parametrize("on_disk", [True, False])
def test_rows_after_a_count_are_dropped(on_disk, tmp_path):
    log = journal_in(tmp_path) if on_disk else StepLog(WIDTH)
    if not on_disk:
        log.append(ROWS)
    log.keep(3)
    log.append(ROWS[4])
    np.testing.assert_array_equal(log.rows(), ROWS[[0, 1, 2, 4]])
    with pytest.raises(InputError, match="holds 4 rows, expected 5 at least: it is damaged"):
        log.keep(5)


def test_filled_journal_goes_on_like_one_that_grew(tmp_path):
    grown = journal_in(tmp_path)
    filled = StepLog(WIDTH, tmp_path / "filled.log")
    filled.fill(ROWS)
    for log in (grown, filled):
        log.append(ROWS[0])
        log.close()
    assert grown.path.read_bytes() == filled.path.read_bytes()
    filled.remove()
    filled.remove()
    assert [file.name for file in tmp_path.iterdir()] == ["rows.log"]


def test_clearing_replaces_a_former_file(tmp_path):
    journal_in(tmp_path).close()
    log = journal_in(tmp_path, ROWS[:0])
    assert len(log) == 0
    assert log.rows().shape == (0, WIDTH)


def test_many_rows_reach_the_file_before_a_flush_and_all_with_it(tmp_path):
    log = journal_in(tmp_path, ROWS[:0])
    for number in range(60_000):
        log.append((float(number), 0.0, 0.0))
    assert log.path.stat().st_size > 8 * WIDTH * 40_000
    np.testing.assert_array_equal(log.rows()[:, 0], np.arange(60_000))


def test_other_files_and_places_are_refused_in_one_line(tmp_path):
    log = journal_in(tmp_path)
    log.close()
    with pytest.raises(InputError, match="is not a log of rows of 4 numbers"):
        StepLog(4, log.path).reopen()
    log.path.write_bytes(b"time,mouth_area\n0.0,1.0\n")
    with pytest.raises(InputError, match="is not a log of rows of 3 numbers"):
        reopened(log.path)
    with pytest.raises(InputError, match="cannot be gone on from: No such file"):
        reopened(tmp_path / "none.log")
    with pytest.raises(InputError, match=r"cannot be written: .*: choose another output folder"):
        journal_in(log.path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the device that is always full is Linux's")
def test_full_disk_is_one_clear_error(tmp_path):
    log = journal_in(tmp_path)
    log.flush()
    log._stream = open("/dev/full", "r+b", buffering=0)  # noqa: SIM115
    log.append(ROWS[0])
    with pytest.raises(RunError, match=r"rows\.log could not be written: No space left"):
        log.flush()
