"""Mouth, rows and figures against closed forms."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from netdae.core.errors import InputError
from netdae.model.material import Material
from netdae.model.mouth import corners_of, loop_of, mouth_of, vector_area
from netdae.model.net import CableNet
from netdae.model.state import EnergyBalance, State
from netdae.model.tether import Chaser, Tether
from netdae.output.histories import HISTORY, figures_of, time_below, time_quantile
from netdae.output.metrics import COLUMNS, CONTACT, DeploymentMetrics
from netdae.runs.summary import net_figures
from netdae.system.closing import Haul, Winch
from netdae.system.closing_assembly import with_closings
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.measurements import Cordage
from netdae.system.meeting import TargetColumns
from netdae.system.system import System
from netdae.system.tether_assembly import with_tether

CORD = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)


NOT_THERE = {*Cordage._fields, *TargetColumns._fields, *CONTACT}
"""Columns of what a bare net has not: cords, a target, contact."""


def rotation(rng: np.random.Generator) -> np.ndarray:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def ring(k: int, first: int = 0) -> list[tuple[int, int]]:
    return [(first + i, first + (i + 1) % k) for i in range(k)]


def system_of(net: CableNet, cord: Material | dict[str, Material] = CORD) -> System:
    return System(net, cord, masses={"corners": 0.5}, damping=Dashpot(viscosity_time=1e-5))


def begun(system: System, **options: str | None) -> DeploymentMetrics:
    metrics = DeploymentMetrics(**options)
    metrics.begin(system)
    return metrics


# Areas


@pytest.mark.parametrize("k", [3, 4, 7, 40])
def test_the_area_of_a_regular_polygon_is_exact_however_it_is_tilted_and_moved(k: int) -> None:
    rng = np.random.default_rng(k)
    angle = 2 * np.pi * np.arange(k) / k
    polygon = 2.0 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(k)])
    points = polygon @ rotation(rng).T + 1e3 * rng.normal(size=3)
    # round-off of coordinates near 1e3 m: 1e-13 m times a perimeter of 12 m
    assert vector_area(points) == pytest.approx(0.5 * k * 4.0 * np.sin(2 * np.pi / k), abs=1e-11)


def test_the_area_of_a_warped_loop_is_the_largest_of_its_shadows() -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(9, 3))

    def shadow(n: np.ndarray) -> float:
        e1 = np.linalg.svd(n[None])[2][1]
        u, w = points @ e1, points @ np.cross(n, e1)
        return 0.5 * float(np.sum(u * np.roll(w, -1) - w * np.roll(u, -1)))

    directions = rng.normal(size=(20_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    largest = max(abs(shadow(n)) for n in directions)
    # 20 000 directions lie within 0.02 rad of any: cosine 2e-4 below one
    assert vector_area(points) * (1 - 2e-4) < largest <= vector_area(points) * (1 + 1e-12)


def test_a_figure_of_eight_and_a_packed_loop_have_no_area() -> None:
    eight = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    assert vector_area(eight) == pytest.approx(0, abs=1e-15)
    assert vector_area(np.full((12, 3), 0.3)) == 0.0


# The loop


def test_a_loop_is_found_in_shuffled_cables_and_numbers() -> None:
    rng = np.random.default_rng(5)
    names = rng.permutation(30)[:12]
    cables = names[np.array(ring(12))]
    cables = np.array([pair[:: rng.choice([-1, 1])] for pair in cables])[rng.permutation(12)]
    loop = loop_of(cables, rng.permutation(names))
    start = int(np.flatnonzero(names == loop[0])[0])
    turned = np.roll(names, -start)
    assert np.array_equal(loop, turned) or np.array_equal(loop, np.roll(turned[::-1], 1))
    assert loop[0] == names.min()


@pytest.mark.parametrize(
    "net",
    [
        CableNet.square(side=5.0, cells=6),
        CableNet.square(side=5.0, cells=1),
        CableNet.rectangle(width=4.0, height=1.0, columns=5, rows=1),
        CableNet.square(side=2.0, cells=2, subdivide=3),
        CableNet.hexagon(radius=2.0, rings=2),
        CableNet.radial(radius=2.0, rings=3, spokes=8),
        CableNet.diamond(side=3.0, cells=3),
    ],
)
def test_the_mouth_of_a_generated_net_is_its_border_with_and_without_a_cable_group(net: CableNet) -> None:
    loop = mouth_of(net, "border")
    assert np.array_equal(np.sort(loop), net.nodes_of("border"))
    border = {frozenset(pair) for pair in net.cables[net.cables_of("border")].tolist()}
    assert {frozenset(pair) for pair in zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True)} == border
    without = replace(net, cable_groups={})
    assert np.array_equal(mouth_of(without, "border"), loop)
    only = replace(net, node_groups={})
    assert np.array_equal(mouth_of(only, "border"), loop)


def loops_by_trial(cables: list[tuple[int, int]], count: int) -> set[frozenset[frozenset[int]]]:
    """All closed loops through all nodes, by trying every order."""
    pairs = {frozenset(pair) for pair in cables}
    loops = set()
    for order in itertools.permutations(range(1, count)):
        walk = [frozenset(pair) for pair in itertools.pairwise((0, *order, 0))]
        if pairs.issuperset(walk):
            loops.add(frozenset(walk))
    return loops


def test_chords_between_knots_that_the_border_uses_up_are_left_out() -> None:
    rng = np.random.default_rng(10)
    for _ in range(30):
        names = rng.permutation(12)
        cables = names[np.array([*ring(12), (0, 5), (3, 10), (6, 8)])]
        border = {frozenset(pair) for pair in names[np.array(ring(12))].tolist()}
        loop = loop_of(cables, names).tolist()
        assert set(map(frozenset, itertools.pairwise([*loop, loop[0]]))) == border


def test_chords_are_left_out_only_where_one_loop_through_all_nodes_remains() -> None:
    rng = np.random.default_rng(11)
    found = refused = 0
    for _ in range(60):
        chords = [tuple(rng.choice(7, 2, replace=False).tolist()) for _ in range(rng.integers(0, 6))]
        cables = ring(7)[rng.integers(0, 2) :] + chords
        true = loops_by_trial(cables, 7)
        try:
            loop = loop_of(np.array(cables), np.arange(7)).tolist()
        except InputError:
            refused += 1
            assert len(true) != 1
            continue
        found += 1
        assert {frozenset(map(frozenset, itertools.pairwise([*loop, loop[0]])))} == true
    assert found >= 15
    assert refused >= 5


@pytest.mark.parametrize(
    ("cables", "members", "reason"),
    [
        (ring(4), [0, 1, 2, 3, 9], "node 9 has no cable to another node of the group"),
        ([*ring(4), (3, 4)], [0, 1, 2, 3, 4], "node 4 has only one cable to another node of the group"),
        ([(0, 1), (1, 2)], [0, 1, 2], "node 0 has only one cable to another node of the group"),
        (
            ring(4) + ring(3, 4),
            list(range(7)),
            "separate loops: node 4 is not on the loop of 4 nodes through node 0",
        ),
        (
            ring(4) + ring(4, 4) + [(1, 5)],
            list(range(8)),
            "node 1 has 3 cables in the group, to nodes 0, 2, 5",
        ),
        ([(i, j) for i in range(4) for j in range(i)], [0, 1, 2, 3], "node 0 has 3 cables in the group"),
        (ring(4), [0, 1], "has 2 nodes, but a closed loop needs at least three"),
    ],
)
def test_what_is_not_one_loop_is_refused_with_its_reason(
    cables: list[tuple[int, int]], members: list[int], reason: str
) -> None:
    with pytest.raises(InputError, match=reason):
        loop_of(np.array(cables), np.array(members))


def test_corners_come_in_the_order_of_the_mouth_also_on_threads_of_their_own() -> None:
    net = CableNet.square(side=5.0, cells=4)
    loop = mouth_of(net, "border")
    corners = corners_of(net, loop, "corners")
    assert np.array_equal(np.sort(corners), net.nodes_of("corners"))
    assert vector_area(net.nodes[corners]) == pytest.approx(25.0, rel=1e-14)  # crossed diagonals would give 0

    rng = np.random.default_rng(2)
    bullets = 25 + rng.permutation(4)
    nodes = np.vstack([net.nodes, np.zeros((4, 3))])
    nodes[bullets] = 1.2 * net.nodes[corners]
    threads = np.column_stack([bullets, corners])
    hung = CableNet(nodes, np.vstack([net.cables, threads]), {**net.node_groups, "bullets": bullets})
    assert np.array_equal(corners_of(hung, mouth_of(hung, "border"), "bullets"), bullets)

    twice = CableNet(nodes, np.vstack([net.cables, np.column_stack([bullets, corners[[0, 1, 2, 2]]])]))
    twice = replace(twice, node_groups={"bullets": bullets, "border": net.nodes_of("border")})
    with pytest.raises(InputError, match="attach to the mouth at the same node"):
        corners_of(twice, loop, "bullets")
    loose = CableNet(nodes, net.cables, {"bullets": bullets})
    with pytest.raises(InputError, match="no cables connect to the mouth"):
        corners_of(loose, loop, "bullets")


# Rows


def test_the_rows_of_a_rigidly_flying_net_follow_from_its_motion() -> None:
    net = CableNet.square(side=4.0, cells=6)
    system = system_of(net)
    metrics = begun(system)
    rng = np.random.default_rng(4)
    velocity, spin, start = np.array([1.0, 2.0, -2.0]), np.array([0.3, -0.2, 0.5]), np.array([3.0, -1.0, 7.0])
    size = np.linalg.norm(spin)
    k = spin / size
    turned = rotation(rng)
    for t in (0.0, 0.4, 2.0):
        a = size * t
        cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        R = (np.eye(3) + np.sin(a) * cross + (1 - np.cos(a)) * cross @ cross) @ turned
        arms = net.nodes @ R.T
        centre = start + velocity * t
        v = velocity + np.cross(spin, arms)
        balance = EnergyBalance(dissipated_energy=0.3 * t, external_work=0.1 * t, peak_tension=17.0 * t)
        metrics(State(t, centre + arms, v, np.zeros_like(v), balance))
        row = dict(zip(COLUMNS, metrics.rows[-1], strict=True))
        mass = system.mass.sum()
        inertia = np.einsum(
            "n,nij->ij",
            system.mass,
            np.einsum("nk,nk,ij->nij", arms, arms, np.eye(3)) - np.einsum("ni,nj->nij", arms, arms),
        )
        kinetic = 0.5 * mass * 9.0 + 0.5 * spin @ inertia @ spin
        angular = np.cross(centre, mass * velocity) + inertia @ spin
        near = {"rel": 1e-12, "abs": 1e-12}  # round-off of some hundred sums
        assert row["time"] == t
        assert row["mouth_area"] == pytest.approx(16.0, **near)
        assert row["corner_area"] == pytest.approx(16.0, **near)
        assert row["distance"] == pytest.approx(3.0 * t, **near)
        assert [row[f"com_{c}"] for c in "xyz"] == pytest.approx(centre, **near)
        assert row["kinetic_energy"] == pytest.approx(kinetic, **near)
        # strains of 1e-16 by round-off store EA L E11² / 2 = 1e-27 J each
        assert row["elastic_energy"] == pytest.approx(0.0, abs=1e-20)
        assert row["dissipated_energy"] == balance.dissipated_energy
        assert row["external_work"] == balance.external_work
        assert row["energy_residual"] == pytest.approx(0.2 * t, **near)
        assert [row[f"momentum_{c}"] for c in "xyz"] == pytest.approx(mass * velocity, **near)
        assert [row[f"angular_momentum_{c}"] for c in "xyz"] == pytest.approx(angular, **near)
        assert row["max_tension"] == 17.0 * t
    assert np.array_equal(metrics.table()["time"], [0.0, 0.4, 2.0])


def test_distance_is_straight_for_a_start_without_momentum_and_taut_cables_are_counted() -> None:
    net = CableNet.square(side=2.0, cells=2)
    metrics = begun(system_of(net))
    v = np.where(np.arange(9)[:, None] < 4, 1.0, 0.0) * net.nodes  # shot apart
    v -= (system_of(net).mass @ v) / system_of(net).mass.sum()
    for t, shift in ((0.0, 0.0), (1.0, 5.0)):
        x = 1.01 * net.nodes * [1, 1 / 1.01, 1] + shift * np.array([0.6, 0, 0.8])
        metrics(State(t, x, v, v, EnergyBalance(peak_tension=3.0)))
    table = metrics.table()
    assert table["distance"] == pytest.approx([0.0, 5.0], abs=1e-12)
    assert table["max_tension"].tolist() == [
        3.0,
        3.0,
    ]  # of the balance: a frame between steps is interpolated
    assert table["taut_fraction"][0] == 0.5  # the cables along x


def test_a_packed_net_gives_no_nan() -> None:
    net = CableNet.square(side=5.0, cells=4)
    metrics = begun(system_of(net))
    state = State(0.0, np.zeros((25, 3)), np.zeros((25, 3)), np.zeros((25, 3)))
    metrics.watch(state)
    metrics(state)
    table = metrics.table()
    assert {name for name, values in table.items() if not np.isfinite(values).all()} == NOT_THERE
    figures = {k: value for k, value in metrics.summary().items() if k != "warnings"}
    assert np.isfinite(list(figures.values())).all()
    assert figures["largest_mouth_area"] == 0.0


def test_a_net_without_mouth_or_corners_has_empty_columns_and_no_figures_of_them() -> None:
    net = CableNet.square(side=5.0, cells=4)
    bare = replace(net, node_groups={"border": net.nodes_of("border"), "pair": np.array([0, 1])})
    bare_system = System(bare, CORD, damping=Dashpot(viscosity_time=1e-5))
    state = State(0.0, net.nodes, net.nodes, net.nodes)
    for options, empty in (
        ({}, {"corner_area"}),
        ({"corners": "pair"}, {"corner_area"}),
        ({"corners": None}, {"corner_area"}),
        ({"mouth": None}, {"corner_area", "mouth_area"}),
    ):
        metrics = begun(bare_system, **options)
        metrics.watch(state)
        metrics(state)
        table = metrics.table()
        assert {name for name, values in table.items() if np.isnan(values).any()} == {
            *empty,
            *NOT_THERE,
        }
        summary = metrics.summary()
        assert ("largest_mouth_area" in summary) == ("mouth_area" not in empty)
        assert "largest_corner_area" not in summary
    with pytest.raises(InputError, match="no node group 'corner'"):
        begun(bare_system, corners="corner")
    for mouth, reason in (("rim", "no node group 'rim'"), ("pair", "has 2 nodes")):
        with pytest.raises(
            InputError, match=rf'{reason}.*mouth = "none" in \[metrics\], mouth=None in Python'
        ):
            begun(bare_system, mouth=mouth)
    with pytest.raises(InputError, match=r"'border'.*mouth=None"):
        begun(
            System(replace(bare, node_groups={}, cable_groups={}), CORD, damping=Dashpot(viscosity_time=1e-5))
        )


# Time at a level, quantiles


def test_the_time_below_a_level_of_a_triangle_wave_is_its_share() -> None:
    times = np.array([0.0, 0.5, 1.0, 1.0, 2.5, 4.0])
    values = np.array([0.0, 5.0, 10.0, 10.0, 5.0, 0.0])  # up in 1 s, down in 3 s
    for level in (-1.0, 0.0, 2.5, 5.0, 8.0, 10.0, 11.0):
        assert time_below(times, values, level) == pytest.approx(4 * np.clip(level / 10, 0, 1), abs=1e-15)
    flat = np.array([1.0, 1.0, 1.0])
    assert time_below(times[:3], flat, 1.0) == 1.0
    assert time_below(times[:3], flat, 1.0, strictly=True) == 0.0


def test_quantiles_of_known_distributions_are_exact_for_uneven_steps() -> None:
    rng = np.random.default_rng(9)
    times = np.sort(np.concatenate([[0.0, 2.0], rng.uniform(0, 2.0, 500)]))
    for share in (0.01, 0.5, 0.9, 0.999, 1.0):
        assert time_quantile(times, 3 * times, share) == pytest.approx(6.0 * share, rel=1e-12)  # uniform
        # f = (t/2)², linear between steps up to 0.04 s: off by less than h²/8 f″ = 1e-4
        assert time_quantile(times, (times / 2) ** 2, share) == pytest.approx(share**2, abs=1e-4)
    # a level held for 30 % of the time is the quantile from 35 % to 65 %
    steps, held = np.array([0.0, 0.35, 0.65, 1.0]), np.array([0.0, 2.0, 2.0, 5.0])
    assert time_quantile(steps, held, 0.36) == time_quantile(steps, held, 0.64) == 2.0
    assert time_quantile(steps, held, 0.825) == pytest.approx(3.5, rel=1e-14)
    assert time_quantile(np.array([1.0]), np.array([4.0]), 0.999) == 4.0


# Figures


def history(**given: np.ndarray) -> dict[str, np.ndarray]:
    count = len(next(iter(given.values())))
    return {name: np.asarray(given.get(name, np.zeros(count)), dtype=float) for name in HISTORY}


def test_the_mouth_of_a_triangle_wave_is_over_80_percent_for_a_fifth_of_the_time() -> None:
    times = np.array([0.0, 0.3, 1.0, 1.7, 4.0])
    areas = np.interp(times, [0.0, 1.0, 4.0], [0.0, 12.0, 0.0])
    figures = figures_of(history(time=times, mouth_area=areas, distance=2 * times, corner_area=areas[::-1]))
    assert figures["largest_mouth_area"] == 12.0
    assert figures["largest_mouth_area_time"] == 1.0
    assert figures["largest_mouth_area_distance"] == 2.0
    assert figures["time_over_80_percent_of_mouth_area"] == pytest.approx(0.8, rel=1e-14)
    assert figures["final_mouth_area"] == 0.0
    assert figures["largest_corner_area"] == 12.0
    assert figures["final_distance"] == 8.0
    assert figures["warnings"] == []


def test_a_short_peak_of_tension_counts_as_peak_but_not_against_the_strength() -> None:
    times = np.array([0.0, 1.0, 1.0002, 1.0004, 2.0])
    load = np.array([0.8, 0.8, 3.0, 0.8, 0.8])
    cables = np.array([4.0, 4, 17, 4, 4])
    h = history(time=times, tension=500 * load, tension_cable=cables, load=load, load_cable=cables)
    figures = figures_of(h)
    assert (figures["peak_tension"], figures["peak_tension_time"], figures["peak_tension_cable"]) == (
        1500,
        1.0002,
        17,
    )
    assert figures["tension_quantile_99_9"] == pytest.approx(400.0)
    assert figures["tension_over_strength"] == pytest.approx(0.8)
    assert figures["peak_tension_over_strength"] == 3.0
    assert figures["warnings"] == []
    over = figures_of({**h, "load": 2 * load})
    assert over["tension_over_strength"] == pytest.approx(1.6)
    assert len(over["warnings"]) == 1
    assert "cable 17" in over["warnings"][0]


def test_energy_warnings_come_just_over_their_limits() -> None:
    times = np.linspace(0, 1, 5)
    kinetic = np.array([100.0, 80, 60, 70, 50])
    elastic = np.array([0.0, 10, 20, 10, 20])
    lost = np.array([0.0, 9.2, 19.5, 19.3, 29.5])  # residual −0.8, −0.5, −0.7, −0.5
    figures = figures_of(
        history(time=times, kinetic_energy=kinetic, elastic_energy=elastic, dissipated_energy=lost)
    )
    assert figures["energy_residual_share"] == pytest.approx(-0.008)
    assert figures["energy_rise_share"] == 0.0
    assert figures["warnings"] == []
    lossy = figures_of(
        history(time=times, kinetic_energy=kinetic, elastic_energy=elastic, dissipated_energy=0.95 * lost)
    )
    assert len(lossy["warnings"]) == 1
    assert "energy residual reaches -2 %" in lossy["warnings"][0]
    # work explains a rise; without it in the balance the rise is the integrator's
    work = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    for booked, rise in ((work, 0.0), (0 * work, 0.4 / 100.4)):
        figures = figures_of(history(time=times, kinetic_energy=100 + work, external_work=booked))
        assert figures["energy_rise_share"] == pytest.approx(rise, abs=1e-15)
        assert len(figures["warnings"]) == (rise > 0)
    # energy that comes back after a loss is a rise too: 100, 90, 92
    sunk = figures_of(history(time=times[:3], kinetic_energy=np.array([100.0, 90.0, 92.0])))
    assert sunk["energy_rise_share"] == pytest.approx(0.02)


def test_a_mouth_that_is_largest_at_the_end_is_warned_of() -> None:
    times = np.array([0.0, 1.0, 2.0])
    opening = figures_of(history(time=times, mouth_area=np.array([1.0, 2.0, 3.0])))
    assert "set a later end" in opening["warnings"][0]
    closing = figures_of(history(time=times, mouth_area=np.array([1.0, 3.0, 2.0])))
    assert closing["warnings"] == []


@pytest.mark.parametrize(("strain", "count"), [(0.49, 0), (0.51, 1)])
def test_a_strain_that_no_cord_survives_is_warned_of(strain: float, count: int) -> None:
    figures = figures_of(history(time=np.array([0.0, 1.0, 2.0]), strain=np.array([0.0, strain, 0.1])))
    assert len([each for each in figures["warnings"] if "peak strain" in each]) == count


def test_the_toe_share_is_measured_in_taut_time_and_warned_of_over_half() -> None:
    net = CableNet.square(side=1.0, cells=1)
    system = system_of(net, replace(CORD, toe_strain=1e-2, strength=1e9))
    metrics = begun(system)
    # uniform stretch e(t) from 0 to 3 ε in 3 s, then slack: in the toe for 1 s of 3 s taut
    for t in np.linspace(0, 3, 3001):
        metrics.watch(State(t, np.sqrt(1 + 2 * 1e-2 * t) * net.nodes, 0 * net.nodes, 0 * net.nodes))
    metrics.watch(State(3.0, 0.5 * net.nodes, 0 * net.nodes, 0 * net.nodes))
    metrics.watch(State(9.0, 0.5 * net.nodes, 0 * net.nodes, 0 * net.nodes))
    figures = metrics.summary()
    assert figures["peak_strain"] == pytest.approx(3e-2, rel=1e-12)
    assert figures["peak_strain_over_toe_strain"] == pytest.approx(3.0, rel=1e-12)
    assert figures["toe_share_of_taut_time"] == pytest.approx(1 / 3, abs=1e-3)  # one step of 1e-3 s
    assert not any("toe" in warning for warning in figures["warnings"])
    lying = history(time=np.array([0.0, 1.0]), taut_count=np.full(2, 10.0), toe_count=np.full(2, 6.0))
    assert "60 % of their time in the toe" in figures_of(lying)["warnings"][0]
    sharp = begun(system_of(net))
    sharp.watch(State(0.0, net.nodes, net.nodes, net.nodes))
    assert not {"toe_share_of_taut_time", "tension_over_strength"} & set(sharp.summary())


def test_the_toe_of_the_engineering_law_ends_at_its_own_strain() -> None:
    """ε is reported in λ − 1, which is less than E11: at λ = 1.099 a cable with ε = 0.1 is in its toe still."""
    net = CableNet.square(side=1.0, cells=1)
    metrics = begun(system_of(net, replace(CORD, toe_strain=0.1, law="engineering")))
    for t, stretch in ((0.0, 1.0), (1.0, 1.099)):
        metrics.watch(State(t, stretch * net.nodes, 0 * net.nodes, 0 * net.nodes))
    figures = metrics.summary()
    assert figures["peak_strain"] == pytest.approx(0.5 * (1.099**2 - 1), rel=1e-12)
    assert figures["peak_strain"] > 0.1
    assert figures["peak_strain_over_toe_strain"] == pytest.approx(0.99, rel=1e-12)
    assert figures["toe_share_of_taut_time"] == 1.0


def test_strength_and_toe_of_some_cables_only_count_there() -> None:
    net = CableNet.square(side=1.0, cells=2)
    cords = {"all": CORD, "border": replace(CORD, toe_strain=1e-2, strength=10.0)}
    metrics = begun(System(net, cords, damping=Dashpot(viscosity_time=1e-5)))
    stretch = np.sqrt(1 + 2 * 5e-3)
    for t in (0.0, 1.0):
        metrics.watch(State(t, stretch * net.nodes, 0 * net.nodes, 0 * net.nodes))
    figures = metrics.summary()
    EA = 70e9 * np.pi / 4 * 1e-6
    assert figures["toe_share_of_taut_time"] == 1.0  # the inner cables have no toe
    assert figures["peak_strain_over_toe_strain"] == pytest.approx(0.5, rel=1e-10)
    assert figures["peak_tension"] == pytest.approx(EA * 5e-3 * stretch, rel=1e-10)
    assert figures["peak_tension_cable"] in net.cables_of("inner")
    assert figures["tension_over_strength"] == pytest.approx(EA * 1.25e-3 * stretch / 10.0, rel=1e-10)
    assert figures["weakest_cable"] in net.cables_of("border")


def test_frames_change_no_figure_of_the_summary() -> None:
    net = CableNet.square(side=5.0, cells=3)
    system = system_of(net, replace(CORD, toe_strain=1e-4, strength=500.0))
    rng = np.random.default_rng(6)
    states = [
        State(
            t,
            net.nodes * rng.uniform(0.9, 1.01),
            rng.normal(size=(16, 3)),
            net.nodes,
            EnergyBalance(t, 0.1 * t),
        )
        for t in np.cumsum(rng.uniform(0, 1, 40))
    ]
    summaries = []
    for every in (1, 7):
        metrics = begun(system)
        for k, state in enumerate(states):
            if k % every == 0:
                metrics(state)  # before watch at the start here, after it below
            metrics.watch(state)
        summaries.append(metrics.summary())
    assert summaries[0] == summaries[1]
    again = begun(system)
    for state in states:
        again.watch(state)
    again(states[0])
    assert again.summary() == summaries[0]
    with pytest.raises(RuntimeError, match="no internal step was watched"):
        begun(system).summary()


def test_the_histories_are_what_the_system_says() -> None:
    net = CableNet.square(side=5.0, cells=8)
    soft = replace(CORD, toe_strain=5e-3, strength=800.0)
    system = system_of(net, {"all": soft, "border": replace(CORD, law="engineering", strength=1000.0)})
    rng = np.random.default_rng(13)
    metrics = begun(system)
    times = np.linspace(0, 1, 6)
    flights = net.nodes + rng.normal(0, 3e-3, (6, 81, 3)), rng.normal(size=(6, 81, 3))
    for t, x, v in zip(times, *flights, strict=True):
        metrics.watch(State(t, x, v, v))
    strain, tension = (np.array([f(x) for x in flights[0]]) for f in (system.strain, system.tension))
    figures = metrics.summary()
    near = {"rel": 1e-12}  # sums of some hundred terms in another order
    assert figures["peak_tension"] == pytest.approx(tension.max(), **near)
    peak = np.unravel_index(tension.argmax(), tension.shape)
    assert (figures["peak_tension_time"], figures["peak_tension_cable"]) == (times[peak[0]], peak[1])
    assert figures["peak_tension_over_strength"] == pytest.approx((tension / system.strength).max(), **near)
    assert figures["weakest_cable"] == (tension / system.strength).max(axis=0).argmax()
    assert figures["peak_strain"] == pytest.approx(strain.max(), **near)
    eps = system.toe_strain
    assert not (system.cords.engineering & (eps > 0)).any()  # else the law's own strain would count
    toed = strain[:, eps > 0] / eps[eps > 0]
    assert figures["peak_strain_over_toe_strain"] == pytest.approx(toed.max(), **near)
    share = np.trapezoid(((toed > 0) & (toed < 1)).sum(1), times) / np.trapezoid((toed > 0).sum(1), times)
    assert 0.1 < figures["toe_share_of_taut_time"] == pytest.approx(share, **near)
    energy = [system.kinetic_energy(v) + system.elastic_energy(x) for x, v in zip(*flights, strict=True)]
    assert figures["largest_energy"] == pytest.approx(max(energy), **near)
    assert figures["final_kinetic_energy"] == pytest.approx(system.kinetic_energy(flights[1][-1]), **near)
    assert figures["final_elastic_energy"] == pytest.approx(system.elastic_energy(flights[0][-1]), **near)


# Tether and closing cords

LINE = Material(youngs_modulus=1e9, density=1000.0, diameter=2e-3, strength=300.0)
"""EA 3.1 kN, 3.1 g/m."""


def tethered(**changes: object) -> tuple[System, np.ndarray, int, Tether]:
    """A 2 m net on a bridle and a tether of 4 cables to a chaser of 50 kg; system, start, own nodes, tether."""
    net = CableNet.square(side=2.0, cells=2)
    given = {"length": 3.2, "bridle": 2.0, "payout": "free", "drum_inertia": 0.05, **changes}
    tether = Tether("corners", 4, LINE, Chaser((0.1, 0.2, -4.5), mass=50.0), **given)  # type: ignore[arg-type]
    tied = with_tether(net, State.at(net.nodes), tether)
    system = System(
        tied.net,
        {"all": CORD, **tied.materials},
        damping=Dashpot(viscosity_time=1e-5),
        masses={"corners": 0.5, **tied.masses},
        restraints=tied.restraints,
        reels=tied.reels,
    )
    return system, tied.start.x, net.node_count, tether


def test_a_row_tells_the_tether_as_it_is_at_the_frame() -> None:
    system, start, n, _ = tethered()
    rng = np.random.default_rng(21)
    x = start.copy()
    x[:-1] += rng.normal(0, 0.02, (len(x) - 1, 3))
    x[-1, 0] = 0.7  # s
    x[system.net.nodes_of("chaser"), 2] -= 0.9  # taut at the chaser
    metrics = begun(system)
    metrics(State(0.0, x, 0 * x, 0 * x))
    row = {name: values[0] for name, values in metrics.table().items()}
    assert [name for name in row if name in Cordage._fields][:3] == [
        "paid_out",
        "tether_tension",
        "chaser_distance",
    ]
    assert row["paid_out"] == 0.7
    chain = system.net.cables_of("tether")
    i, j = system.net.cables[chain].T
    L = np.array([0.8, 0.8, 0.8, 0.8 + 0.7])
    E11 = 0.5 * (np.sum((x[j] - x[i]) ** 2, axis=1) / L**2 - 1)
    N = 1e9 * np.pi * 1e-6 * E11 * np.sqrt(1 + 2 * E11)
    assert N.max() > 10.0
    assert row["tether_tension"] == pytest.approx(N.max(), rel=1e-9)  # E11 of 1e-2 from squares of lengths
    assert row["tether_tension"] == system.tension(x)[chain].max()
    assert N.max() < system.tension(x).max()  # of the net, in which the noise pulls harder
    com = system.mass[:n] @ x[:n] / system.mass[:n].sum()
    assert row["chaser_distance"] == pytest.approx(
        float(np.linalg.norm(com - x[system.net.nodes_of("chaser")])), rel=1e-14
    )
    assert np.isnan([row["closing_length"], row["closing_tension"]]).all()


def test_the_summary_of_a_tether_is_of_all_steps_and_its_end() -> None:
    system, start, n, tether = tethered()
    chain, chaser = system.net.cables_of("tether"), system.net.nodes_of("chaser")
    metrics = begun(system)
    states = []
    for t, s, way in ((0.0, 0.0, 0.0), (0.4, 0.1, 1.3), (0.5, 0.4, 1.35), (1.0, 0.6, 0.0)):
        x = start.copy()
        x[-1, 0] = s
        x[chaser, 2] -= way
        if t == 1.0:
            x[:n] *= 1.5  # the net is taut, the tether is not
        states.append(State(t, x, 0 * x, 0 * x))
        metrics.watch(states[-1])
    tension = [system.tension(state.x)[chain].max() for state in states]
    assert tension[1] > tension[2] > 0 == tension[0] == tension[3]
    assert system.peak_tension(states[3].x) > tension[1]
    reported = metrics.tether_summary(states[-1])
    assert [reported[name] for name in ("paid_out", "length", "final_distance")] == pytest.approx(
        [0.6, 3.8, metrics.row_of(states[-1])[COLUMNS.index("chaser_distance")]], rel=1e-14
    )
    assert reported["mass_left"] == pytest.approx(tether.mass_left(0.6), rel=1e-14)
    near = {"rel": 1e-12}  # sums of squares in another order
    assert (reported["peak_tension"], reported["peak_tension_time"]) == (
        pytest.approx(tension[1], **near),
        0.4,
    )
    assert reported["peak_tension_over_strength"] == pytest.approx(tension[1] / 300.0, **near)
    quantile = time_quantile(np.array([0.0, 0.4, 0.5, 1.0]), np.array(tension), 0.999)
    assert reported["tension_over_strength"] == pytest.approx(quantile / 300.0, **near)


def test_a_locked_tether_has_no_length_paid_out_and_a_net_alone_no_tether() -> None:
    system, x, *_ = tethered(payout="locked", drum_inertia=0.0)
    state = State(0.0, x, 0 * x, 0 * x)
    metrics = begun(system)
    metrics(state)
    metrics.watch(state)
    row = dict(zip(COLUMNS, metrics.rows[0], strict=True))
    assert np.isnan(row["paid_out"])
    assert row["tether_tension"] == 0.0
    assert row["chaser_distance"] > 4.0
    assert {"paid_out", "mass_left"} & metrics.tether_summary(state).keys() == set()
    assert metrics.tether_summary(state)["length"] == pytest.approx(3.2, rel=1e-14)

    net = CableNet.square(side=2.0, cells=2)
    alone = begun(system_of(net))
    alone.watch(state := State.at(net.nodes))
    assert alone.tether_summary(state) == {}
    assert np.isnan(alone.history[0, HISTORY.index("tether_tension")])


def test_the_masses_of_net_tether_and_chaser_are_what_one_weighs_and_add_up() -> None:
    system, *_ = tethered()
    reported = net_figures(system)
    cord = 1390.0 * np.pi / 4 * 1e-6 * 24.0 / 2  # 12 cables of 1 m
    near = {"rel": 1e-12}  # 50 kg less the gram of a cable's half
    assert reported["cable_mass"] == pytest.approx(cord, **near)
    assert reported["mass"] == pytest.approx(cord + 4 * 0.5, **near)
    assert reported["tether_mass"] == pytest.approx(1000.0 * np.pi * 1e-6 * (3.2 + 4 * 2.0), **near)
    assert reported["chaser_mass"] == pytest.approx(50.0, **near)
    total = reported["mass"] + reported["tether_mass"] + reported["chaser_mass"]
    assert total == pytest.approx(system.spatial_mass.sum(), **near)
    alone = net_figures(system_of(CableNet.square(side=2.0, cells=2)))
    assert alone.keys() == {"nodes", "cables", "mass", "cable_mass"}
    for name in ("mass", "cable_mass"):
        assert alone[name] == pytest.approx(reported[name], **near)


def test_closing_cords_tell_what_is_left_of_them_and_how_they_pull() -> None:
    net = CableNet.square(side=2.0, cells=2)
    pairs = replace(net, node_groups={**net.node_groups, "left": [0, 1], "right": [7, 8]})
    winch = Winch("left", "right", LINE, Haul(speed=1.0, force=20.0, final_length=0.5))
    closed = with_closings(pairs, State.at(net.nodes), [winch])
    system = System(
        closed.net,
        {"all": CORD, **closed.materials},
        damping=Dashpot(viscosity_time=1e-5),
        reels=closed.reels,
        forces=closed.forces,
        restraints=closed.restraints,
    )
    x = closed.start.x.copy()
    x[-2:, 0] = 0.02, 0.3
    metrics = begun(system)
    metrics(State(0.0, x, 0 * x, 0 * x))
    row = dict(zip(COLUMNS, metrics.rows[0], strict=True))
    L = np.linalg.norm(net.nodes[[7, 8]] - net.nodes[[0, 1]], axis=1)
    left = L - [0.02, 0.3]
    assert row["closing_length"] == pytest.approx(left.sum(), rel=1e-14)
    E11 = 0.5 * ((L / left) ** 2 - 1)
    N = 1e9 * np.pi * 1e-6 * E11 * np.sqrt(1 + 2 * E11)
    assert row["closing_tension"] == pytest.approx(N.max(), rel=1e-12)
    assert np.isnan([row["paid_out"], row["tether_tension"], row["chaser_distance"]]).all()


@pytest.mark.parametrize(("growth", "count"), [(1e-12, 0), (1e-3, 1)])
def test_a_mouth_that_grows_by_round_off_alone_does_not_open(growth, count):
    net = CableNet.square(side=2.0, cells=2)
    cord = Material(youngs_modulus=1e9, density=1000.0, diameter=1e-3)
    system = System(net, cord, damping=NoDamping())
    metrics = DeploymentMetrics()
    metrics.begin(system)
    for t in (0.0, 0.1, 0.2):
        metrics.watch(State.at(net.nodes * (1 + t * growth), t=t))
    assert len([line for line in metrics.summary()["warnings"] if "may open further" in line]) == count
