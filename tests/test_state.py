"""Trajectories on disk: what is written is read, and what is none is reported in one line."""

import numpy as np
import pytest

from netdae.core.errors import InputError
from netdae.model.state import EnergyBalance, State, Trajectory


def trajectory():
    rng = np.random.default_rng(0)
    return Trajectory.of(
        [
            State(t, *rng.standard_normal((3, 40, 3)), EnergyBalance(t, 2 * t, (t, 0.0, -t), 3 * t))
            for t in (0.0, 0.1, 0.3)
        ]
    )


def test_a_trajectory_is_read_as_it_was_written_from_file_and_folder(tmp_path):
    flight = trajectory()
    flight.save(tmp_path / "trajectory.npz")
    for source in (tmp_path, tmp_path / "trajectory.npz"):
        read = Trajectory.load(source)
        for one, other in zip(flight, read, strict=True):
            assert (one.t, one.balance) == (other.t, other.balance)
            for name in "xva":
                np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert [path.name for path in tmp_path.iterdir()] == ["trajectory.npz"]


def cut_off(content):
    return content[: len(content) // 2]


def with_a_wrong_byte(content):
    middle = len(content) // 4  # among the packed positions
    return content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :]


@pytest.mark.parametrize(
    "damage",
    [cut_off, with_a_wrong_byte, lambda content: b"", lambda content: b"PK\3\4", lambda content: b"no zip"],
    ids=["cut off", "wrong byte", "empty", "head of a zip", "text"],
)
def test_a_damaged_trajectory_is_reported_in_one_line(damage, tmp_path):
    file = tmp_path / "trajectory.npz"
    trajectory().save(file)
    file.write_bytes(damage(file.read_bytes()))
    with pytest.raises(
        InputError, match=r"trajectory\.npz is not a trajectory of netdae, or damaged: .*run"
    ) as caught:
        Trajectory.load(tmp_path)
    assert "\n" not in str(caught.value)


def test_other_arrays_are_no_trajectory(tmp_path):
    np.savez(tmp_path / "other.npz", times=[0.0])
    with (tmp_path / "single.npz").open("wb") as stream:
        np.save(stream, np.zeros(3))
    for name in ("other.npz", "single.npz"):
        with pytest.raises(InputError, match="is not a trajectory of netdae"):
            Trajectory.load(tmp_path / name)
    with pytest.raises(InputError, match="is not there: give the output folder"):
        Trajectory.load(tmp_path / "none.npz")
