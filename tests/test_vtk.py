"""The ParaView series: what it holds, and that it is whole at every moment."""

from __future__ import annotations

import os
import resource
import signal
import time
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista as pv

from netdae.core.errors import InputError, RunError
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.output import pvd
from netdae.output.pvd import read_series
from netdae.output.vtk import CELL_DATA, POINT_DATA, RESTRAINED, VtuSeries, read_frame
from netdae.system.damping import Dashpot
from netdae.system.system import System

CORD = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3, toe_strain=1e-4)


def system_of(cells: int) -> System:
    net = CableNet.square(side=5.0, cells=cells)
    return System(net, CORD, masses={"corners": 0.5}, damping=Dashpot(viscosity_time=1e-5))


def states_of(system: System, times: list[float], seed: int = 1) -> list[State]:
    """States with slack and taut cables."""
    rng = np.random.default_rng(seed)
    shape = system.net.nodes.shape
    return [
        State(
            t, system.net.nodes + rng.normal(0, 1e-3, shape), rng.normal(size=shape), rng.normal(size=shape)
        )
        for t in times
    ]


def write(path: Path, system: System, states: list[State]) -> VtuSeries:
    series = VtuSeries(path)
    series.begin(system)
    for state in states:
        series(state)
    series.end()
    return series


def expected_of(system: System, state: State) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Point and cell data from the definitions, independent of the writer."""
    i, j = system.net.cables.T
    l2 = ((state.x[j] - state.x[i]) ** 2).sum(axis=1)
    strain = 0.5 * (l2 / system.net.rest_length**2 - 1)
    stress = np.where(strain < 1e-4, strain**2 / 2e-4, strain - 0.5e-4) * 70e9 * (strain > 0)
    tension = stress * np.pi / 4 * 1e-6 * np.sqrt(l2) / system.net.rest_length
    points = {
        "displacement": state.x - system.net.nodes,
        "velocity": state.v,
        "acceleration": state.a,
        "mass": system.mass,
    }
    cells = {"strain": strain, "stress": stress, "tension": tension, "taut": strain > 0}
    return points, cells


def close(found: np.ndarray, true: np.ndarray, tolerance: float) -> bool:
    return bool(np.abs(found - true).max() <= tolerance * np.abs(true).max())


def test_frames_hold_the_states_to_the_last_digit_for_pyvista_and_meshio(tmp_path: Path) -> None:
    system = system_of(60)  # 3721 nodes: arrays of several compressed blocks
    states = states_of(system, [0.0, 0.1, 1 / 3])
    write(tmp_path / "series.pvd", system, states)
    named = read_series(tmp_path / "series.pvd")
    assert [t for t, _ in named] == [0.0, 0.1, 1 / 3]
    for state, (t, file) in zip(states, named, strict=True):
        points, cells = expected_of(system, state)
        grid, other = read_frame(file), meshio.read(file)
        assert grid.field_data["TimeValue"] == t
        for positions, cables in (
            (grid.points, grid.cells.reshape(-1, 3)[:, 1:]),
            (other.points, other.cells_dict["line"]),
        ):
            assert np.array_equal(positions, state.x)
            assert np.array_equal(cables, system.net.cables)
        for name, true in points.items():
            assert close(grid.point_data[name], true, 1e-15), name
            assert close(other.point_data[name], true, 1e-15), name
        for name, true in cells.items():
            # strains of 1e-2 are differences of squared lengths near 1, known to 1e-16
            assert close(grid.cell_data[name], true, 1e-13), name
            assert np.array_equal(other.cell_data[name][0], grid.cell_data[name]), name
        assert grid.cell_data["taut"].dtype == np.uint8
        assert 0 < grid.cell_data["taut"].sum() < system.net.cable_count


def test_groups_can_be_selected_in_paraview(tmp_path: Path) -> None:
    square = CableNet.square(side=1.0, cells=3)
    net = CableNet(
        square.nodes,
        square.cables,
        {**square.node_groups, 'a <&"b': np.array([2, 3]), "none": np.array([], dtype=int)},
        square.cable_groups,
    )
    system = System(net, CORD, damping=Dashpot(viscosity_time=1e-5))
    write(tmp_path / "series.pvd", system, states_of(system, [0.0]))
    grid = read_frame(tmp_path / "frames" / "frame_000000.vtu")
    assert np.array_equal(np.flatnonzero(grid.point_data["group_corners"]), net.nodes_of("corners"))
    assert np.array_equal(np.flatnonzero(grid.cell_data["group_border"]), net.cables_of("border"))
    assert np.array_equal(np.flatnonzero(grid.point_data["group_a____b"]), [2, 3])  # no XML in a name
    assert not any(name in grid.point_data for name in ("group_all", "group_none"))


def test_frames_tell_how_many_axes_of_a_node_are_restrained_while_they_are(tmp_path: Path) -> None:
    net = CableNet.square(side=1.0, cells=2)
    restraints = [
        Restraint("corners", until=0.2),
        Restraint("centre", axes="xz", begin=0.1, until="caught"),
        Restraint("centre", axes="y"),
    ]
    system = System(net, CORD, damping=Dashpot(viscosity_time=1e-5), restraints=restraints)
    fired: dict[str, float] = {}
    series = VtuSeries(tmp_path / "series.pvd", fired=lambda: fired)
    series.begin(system)
    for state in states_of(system, [0.0, 0.1, 0.2, 0.3]):
        if state.t > 0.25:
            fired["caught"] = 0.25
        series(state)
    corners, centre = net.nodes_of("corners"), net.nodes_of("centre")
    for (_, file), at_corners, at_centre in zip(
        read_series(series.path), (3, 3, 0, 0), (1, 3, 3, 1), strict=True
    ):
        reported = np.zeros(net.node_count)
        reported[corners], reported[centre] = at_corners, at_centre
        restrained = read_frame(file).point_data[RESTRAINED]
        assert restrained.dtype == np.uint8
        np.testing.assert_array_equal(restrained, reported)


def test_frames_are_raw_appended_and_compressed(tmp_path: Path) -> None:
    system = system_of(20)
    write(tmp_path / "series.pvd", system, [State(0.0, *(np.zeros((3, 441, 3))))])
    head = (tmp_path / "frames" / "frame_000000.vtu").read_bytes()
    assert b'compressor="vtkZLibDataCompressor"' in head
    assert b'<AppendedData encoding="raw">' in head
    assert b'format="binary"' not in head


def test_pyvista_reads_the_series_as_a_time_series(tmp_path: Path) -> None:
    system = system_of(4)
    states = states_of(system, [0.0, 0.25, 1e-7 + 0.5])
    write(tmp_path / "series.pvd", system, states)
    reader = pv.get_reader(str(tmp_path / "series.pvd"))
    assert reader.time_values == [state.t for state in states]
    reader.set_active_time_value(states[1].t)
    assert np.array_equal(reader.read()[0].points, states[1].x)


def test_a_new_series_replaces_a_longer_one_and_leaves_other_files_alone(tmp_path: Path) -> None:
    system = system_of(2)
    write(tmp_path / "series.pvd", system, states_of(system, [0.0, 1.0, 2.0]))
    mine = tmp_path / "frames" / "notes.txt"
    mine.write_text("keep")
    (tmp_path / "frames" / "frame_000007.vtu.part").write_text("from a kill")
    write(tmp_path / "series.pvd", system, states_of(system, [0.5]))
    assert sorted(p.name for p in (tmp_path / "frames").iterdir()) == ["frame_000000.vtu", "notes.txt"]
    assert [t for t, _ in read_series(tmp_path / "series.pvd")] == [0.5]


def test_the_series_names_every_frame_up_to_1000_and_lags_by_a_thousandth_beyond(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pvd, "_EVERY_FRAME_UP_TO", 10)
    system = system_of(1)
    series = VtuSeries(tmp_path / "series.pvd")
    series.begin(system)
    writes = 0
    for k, state in enumerate(states_of(system, list(np.arange(100.0))), start=1):
        before = (tmp_path / "series.pvd").stat().st_ino
        series(state)
        writes += (tmp_path / "series.pvd").stat().st_ino != before
        named = len(read_series(tmp_path / "series.pvd"))
        assert named == k if k <= 10 else k * (1 - 1 / 10) <= named <= k
    assert writes < 45  # 10 at first, then every 2nd, 3rd, ... 10th
    series.end()
    assert len(read_series(tmp_path / "series.pvd")) == 100


def opens_whole(folder: Path, system: System) -> int:
    """Assert that the series in `folder` is whole; its number of frames."""
    named = read_series(folder / "series.pvd")
    for _, file in named:
        grid = read_frame(file)
        assert grid.n_points == system.net.node_count
        assert grid.n_cells == system.net.cable_count
        for data, names in ((grid.point_data, POINT_DATA), (grid.cell_data, CELL_DATA)):
            assert all(np.isfinite(data[name]).all() for name in names)
    return len(named)


def fork_and_write(
    folder: Path, system: System, states: list[State], limit: tuple[int, int] | None = None
) -> int:
    """Child that writes frames without end; `limit`: after so many frames no file may pass so many bytes."""
    pid = os.fork()
    if pid:
        return pid
    try:
        series = VtuSeries(folder / "series.pvd")
        series.begin(system)
        k = 0
        while True:
            if limit is not None and k == limit[0]:
                signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit[1], limit[1]))
            series(State(0.01 * k, states[k % 2].x, states[k % 2].v, states[k % 2].a))
            k += 1
    finally:
        os._exit(1)


def test_a_series_killed_at_20_random_moments_opens_whole(tmp_path: Path) -> None:
    system = system_of(40)
    states = states_of(system, [0.0, 1.0])
    rng = np.random.default_rng(7)
    frames = []
    for k, delay in enumerate(rng.uniform(0.01, 0.15, 20)):
        folder = tmp_path / str(k)
        folder.mkdir()
        pid = fork_and_write(folder, system, states)
        while not (folder / "series.pvd").exists():
            time.sleep(1e-3)
        time.sleep(delay)
        os.kill(pid, signal.SIGKILL)
        assert os.WTERMSIG(os.waitpid(pid, 0)[1]) == signal.SIGKILL
        frames.append(opens_whole(folder, system))
    assert len(set(frames)) >= 3, frames  # the moments differ
    assert max(frames) >= 3, frames


def test_a_series_killed_within_a_write_opens_whole(tmp_path: Path) -> None:
    # the file-size limit kills in the middle of a write: exactly so many bytes of the file are on disk
    system = system_of(20)
    states = states_of(system, [0.0, 1.0])
    rng = np.random.default_rng(8)
    for k in range(20):
        folder = tmp_path / str(k)
        folder.mkdir()
        after, size = int(rng.integers(1, 6)), int(rng.integers(1, 60_000))
        pid = fork_and_write(folder, system, states, (after, size))
        assert os.WTERMSIG(os.waitpid(pid, 0)[1]) == signal.SIGXFSZ
        partial = folder / "frames" / f"frame_{after:06d}.vtu.part"
        assert partial.stat().st_size == size
        assert opens_whole(folder, system) == after
    with pytest.raises(InputError, match="cut off"):
        read_frame(partial)


def test_a_series_killed_within_the_write_of_its_list_opens_whole(tmp_path: Path) -> None:
    system = system_of(1)  # frames of 4 kB, so that the list passes the limit first
    folder = tmp_path / "x"
    folder.mkdir()
    pid = fork_and_write(folder, system, states_of(system, [0.0, 1.0]), (1, 20_000))
    assert os.WTERMSIG(os.waitpid(pid, 0)[1]) == signal.SIGXFSZ
    assert (folder / "series.pvd.part").stat().st_size == 20_000
    assert opens_whole(folder, system) > 100


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is always full")
def test_a_full_disk_is_one_clear_error(tmp_path: Path) -> None:
    system = system_of(2)
    states = states_of(system, [0.0, 0.5])
    series = VtuSeries(tmp_path / "series.pvd")
    series.begin(system)
    series(states[0])
    (tmp_path / "frames" / "frame_000001.vtu.part").symlink_to("/dev/full")
    with pytest.raises(RunError, match=r"frame_000001.vtu at t = 0.5 s .*No space left.* so far: 1$"):
        series(states[1])
    series.end()
    assert opens_whole(tmp_path, system) == 1


def test_wrong_places_and_files_are_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"series\.vtu is not a series: give a file that ends in \.pvd"):
        VtuSeries(tmp_path / "series.vtu")
    (tmp_path / "file").write_text("<VTKFile")
    with pytest.raises(InputError, match=r"cannot be written: .*: choose another output folder"):
        VtuSeries(tmp_path / "file" / "series.pvd").begin(system_of(1))
    with pytest.raises(InputError, match=r"nothing\.pvd cannot be read: No such file"):
        read_series(tmp_path / "nothing.pvd")
    with pytest.raises(InputError, match=r"is not a \.pvd series"):
        read_series(tmp_path / "file")
    with pytest.raises(InputError, match="cut off"):
        read_frame(tmp_path / "file")
    pv.UnstructuredGrid(np.array([2, 0, 1]), [3], np.eye(3)[:2]).save(tmp_path / "bare.vtu")
    with pytest.raises(InputError, match="has no acceleration, displacement, mass, velocity, strain"):
        read_frame(tmp_path / "bare.vtu")
