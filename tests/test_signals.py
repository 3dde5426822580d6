"""Signals and motions: values on both sides of jumps, declared kinks, tables against scipy and differences."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from netdae.core.errors import InputError
from netdae.model.motions import Fixed, FunctionMotion, TableMotion, check_derivatives
from netdae.model.signals import Constant, Function, Pulse, Table, signal_of

BEFORE, AFTER = (lambda t: math.nextafter(t, -math.inf)), (lambda t: math.nextafter(t, math.inf))


def test_three_numbers_a_function_and_a_signal_become_signals():
    assert isinstance(signal_of([1, 2, 3]), Constant)
    assert isinstance(signal_of(lambda t: [t, 0, 0]), Function)
    pulse = Pulse([1, 0, 0], 0.0, 1.0)
    assert signal_of(pulse) is pulse
    np.testing.assert_array_equal(signal_of(lambda t: [t, 0, 0])(0.5), [0.5, 0, 0])


def test_a_pulse_has_both_values_at_its_ends():
    pulse = Pulse([2.0, 0.0, 0.0], 0.1, 0.3)
    assert pulse.jumps == (0.1, 0.3)
    assert pulse.kinks == ()
    assert [pulse(t)[0] for t in (BEFORE(0.1), AFTER(0.1), BEFORE(0.3), AFTER(0.3))] == [0.0, 2.0, 2.0, 0.0]
    assert Pulse([1, 0, 0], 0.1, math.inf).jumps == (0.1,)
    assert [pulse(t)[0] for t in (0.1, 0.3)] == [2.0, 0.0]  # from its begin up to its end


def test_a_linear_table_goes_straight_from_row_to_row_and_jumps_where_a_time_stands_twice():
    table = Table([0.0, 1.0, 1.0, 3.0], [[0, 0, 0], [2, 0, 0], [5, 0, 0], [1, 0, 0]])
    assert table.jumps == (1.0,)
    assert table(0.25)[0] == pytest.approx(0.5)
    assert table(2.0)[0] == pytest.approx(3.0)
    assert table(BEFORE(1.0))[0] == pytest.approx(2.0)
    assert table(AFTER(1.0))[0] == pytest.approx(5.0)
    assert table.covers(0.0, 3.0)
    assert not table.covers(-0.1, 1.0)
    assert not table.covers(0.0, 3.1)


def test_inner_rows_of_a_linear_table_are_kinks_and_of_a_cubic_one_are_not():
    times, values = np.linspace(0.0, 1.0, 6), np.zeros((6, 3))
    assert Table(times, values).kinks == tuple(times[1:-1])
    assert Table(times, values, "cubic").kinks == ()


def test_a_cubic_table_is_a_natural_spline_from_jump_to_jump():
    times = np.array([0.0, 0.4, 1.0, 1.0, 1.3, 2.0])
    values = np.random.default_rng(0).standard_normal((6, 3))
    table = Table(times, values, "cubic")
    for rows in (slice(0, 3), slice(3, 6)):
        spline = CubicSpline(times[rows], values[rows], bc_type="natural")
        for t in np.linspace(times[rows][0] + 1e-9, times[rows][-1] - 1e-9, 7):
            np.testing.assert_allclose(table(t), spline(t), rtol=1e-12)
    np.testing.assert_allclose(table(2.0), values[-1], rtol=1e-12)


@pytest.mark.parametrize(
    ("times", "values", "words"),
    [
        ([0.0], [[0, 0, 0]], "two rows"),
        ([0.0, 1.0], [[0, 0], [1, 1]], "3 values"),
        ([0.0, 1.0, 0.5], np.zeros((3, 3)), "do not rise at row 3"),
        ([0.0, 1.0, 1.0, 1.0, 2.0], np.zeros((5, 3)), "do not rise at row 4"),
        ([0.0, 0.0, 1.0], np.zeros((3, 3)), "first or last row"),
        ([0.0, 1.0, 1.0], np.zeros((3, 3)), "first or last row"),
        ([0.0, 1.0], [[0, 0, 0], [math.nan, 0, 0]], "row 2"),
        ([0.0, math.inf], np.zeros((2, 3)), "row 2"),
    ],
)
def test_a_table_that_cannot_be_joined_is_reported_with_its_row(times, values, words):
    with pytest.raises(InputError, match=words):
        Table(times, values)


def test_other_wrong_signals_are_reported():
    with pytest.raises(InputError, match="quintic"):
        Table([0.0, 1.0], np.zeros((2, 3)), "quintic")
    with pytest.raises(InputError, match="end come after"):
        Pulse([1, 0, 0], 0.2, 0.1)
    with pytest.raises(InputError, match="three finite numbers"):
        Constant([1.0, 2.0])
    with pytest.raises(InputError, match=r"t = 0\.5 s.*three numbers"):
        Function(lambda t: [t, t])(0.5)


def assert_derivatives(motion, t, h=1e-6):
    (u0, v0, _), (_, v, a), (u1, v1, _) = motion.at(t - h), motion.at(t), motion.at(t + h)
    # round-off 1e-16/h, truncation h² times derivatives of some hundreds
    np.testing.assert_allclose((u1 - u0) / (2 * h), v, rtol=0, atol=1e-8)
    np.testing.assert_allclose((v1 - v0) / (2 * h), a, rtol=0, atol=1e-6)


@pytest.mark.parametrize("velocities", [None, "given"])
def test_a_cubic_motion_passes_its_rows_with_derivatives_that_belong_together(velocities):
    rng = np.random.default_rng(1)
    times, u = np.array([0.0, 0.3, 0.7, 1.5]), rng.standard_normal((4, 3))
    given = rng.standard_normal((4, 3)) if velocities else None
    motion = TableMotion(times, u, given)
    for row, t in enumerate(times):
        at = motion.at(t)
        np.testing.assert_allclose(at[0], u[row], rtol=0, atol=1e-14)
        if velocities:
            np.testing.assert_allclose(at[1], given[row], rtol=0, atol=1e-13)
    for t in (0.1, 0.5, 1.2):
        assert_derivatives(motion, t)
    assert motion.jumps == ()
    assert motion.kinks == ((0.3, 0.7) if velocities else ())
    if not velocities:  # starts and ends at rest, and its acceleration is continuous
        np.testing.assert_allclose([motion.at(t)[1] for t in (0.0, 1.5)], 0.0, atol=1e-13)
        before, after = motion.at(0.3 - 1e-9)[2], motion.at(0.3 + 1e-9)[2]
        np.testing.assert_allclose(before, after, rtol=1e-6)


def test_a_linear_motion_jumps_in_velocity_where_its_slope_changes():
    motion = TableMotion(
        [0.0, 1.0, 2.0, 3.0], [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0]], interpolation="linear"
    )
    assert motion.jumps == (2.0,)
    np.testing.assert_allclose(motion.at(BEFORE(2.0))[1], [1, 0, 0])
    np.testing.assert_allclose(motion.at(AFTER(2.0))[1], [0, 1, 0])
    np.testing.assert_allclose(motion.at(2.5)[0], [2, 0.5, 0])
    assert not motion.at(2.5)[2].any()
    assert motion.covers(0.0, 3.0)
    assert not motion.covers(0.0, 3.5)


@pytest.mark.parametrize("rows", [3, 11, 1001, 10_001])
@pytest.mark.parametrize("begin", [0.0, 50.0])
def test_round_off_of_a_straight_table_is_no_jump_and_a_true_change_of_slope_is_one(rows, begin):
    """A step rounds to 1e-16 of u and t: at 50 s and 1e-4 s a row, 1e-10 of the slope."""
    times = begin + np.linspace(0.0, 1.0, rows)
    u = np.multiply.outer(np.arange(rows) / (rows - 1), [0.3, -0.7, 0.1])
    assert TableMotion(times, u, interpolation="linear").jumps == ()
    middle = times[rows // 2]
    bent = u + 1e-6 * np.maximum(times - middle, 0.0)[:, None]
    assert TableMotion(times, bent, interpolation="linear").jumps == (middle,)


def test_a_motion_by_functions_and_no_motion():
    motion = FunctionMotion(lambda t: [t**3, 0, 0], lambda t: [3 * t**2, 0, 0], lambda t: [6 * t, 0, 0])
    assert_derivatives(motion, 0.7)
    assert not np.any(Fixed().at(3.0))
    assert Fixed().covers(-1e9, 1e9)


def test_wrong_motions_are_reported():
    with pytest.raises(InputError, match="position cannot jump"):
        TableMotion([0.0, 1.0, 1.0, 2.0], np.zeros((4, 3)))
    with pytest.raises(InputError, match="leave them out"):
        TableMotion([0.0, 1.0], np.zeros((2, 3)), np.zeros((2, 3)), interpolation="linear")


@pytest.mark.parametrize("name", ["displacement", "velocity", "acceleration"])
@pytest.mark.parametrize("value", [[1.0, 2.0], 0.0, np.zeros((1, 3))])
def test_a_function_of_a_motion_that_gives_anything_but_three_numbers_is_reported(name, value):
    functions = {each: lambda t: [0, 0, 0] for each in ("displacement", "velocity", "acceleration")}
    with pytest.raises(InputError, match=rf"motion: the {name} at t = 0\.5 s is .*three numbers"):
        FunctionMotion(**{**functions, name: lambda t: value}).at(0.5)


# Derivatives that belong together


def along_x(u, du, ddu, **breaks):
    return FunctionMotion(*(lambda t, f=f: [f(t), 0.0, 0.0] for f in (u, du, ddu)), **breaks)


def shake(w, begin=0.0, wrong=(1.0, 1.0)):
    """cos w(t − begin) − 1 with derivatives that are `wrong` times the right ones."""
    return along_x(
        lambda t: np.cos(w * (t - begin)) - 1,
        lambda t: -wrong[0] * w * np.sin(w * (t - begin)),
        lambda t: -wrong[1] * w**2 * np.cos(w * (t - begin)),
    )


def ramp(rest, **breaks):
    """Half a second at rest, then 2 m/s²; `rest` is the displacement's second part where that is wrong."""
    return along_x(
        lambda t: max(t - 0.5, 0.0) ** 2,
        lambda t: 2 * max(t - 0.5, 0.0),
        lambda t: rest if t > 0.5 else 0.0,
        **breaks,
    )


def turn(t):
    """1 m/s, from 0.3 s on −1 m/s."""
    return 0.3 - abs(t - 0.3)


RIGHT = {
    "at rest": (along_x(lambda t: 0.0, lambda t: 0.0, lambda t: 0.0), 0.0, 1.0),
    "steady": (along_x(lambda t: 3 * t, lambda t: 3.0, lambda t: 0.0), 0.0, 1e4),
    "slow": (shake(0.1), 0.0, 1.0),
    "fast": (shake(1e5), 0.0, 1.0),
    "fast for long": (shake(2 * np.pi * 10), 0.0, 1000.0),
    "late": (shake(300.0, 1e6), 1e6, 1e6 + 1),
    "jump that is declared": (
        along_x(turn, lambda t: 1.0 if t < 0.3 else -1.0, lambda t: 0.0, jumps=(0.3,)),
        0.0,
        0.6,
    ),
    "kinks side by side": (ramp(2.0, kinks=(0.5, np.nextafter(0.5, 1))), 0.0, 1.0),
    "kink that is not declared": (ramp(2.0), 0.0, 1.0),
    "place far away": (
        along_x(lambda t: (7e6 + t**2) - 7e6, lambda t: 2 * t, lambda t: 2.0),
        0.0,
        1.0,
    ),
    "a table": (TableMotion([0, 1, 2.0], [[0, 0, 0], [1, 0, 0], [0, 0, 0]]), 0.0, 2.0),
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_motion_whose_derivatives_belong_together_passes(name):
    motion, begin, end = RIGHT[name]
    check_derivatives(motion, np.arange(3), begin, end)


WRONG = {
    "velocity left out": (shake(3.0, wrong=(0.0, 1.0)), "velocity"),
    "acceleration left out": (shake(3.0, wrong=(1.0, 0.0)), "acceleration"),
    "a factor of a fast motion": (shake(1e4, wrong=(1.0, 1e-4)), "acceleration"),
    "a percent": (shake(3.0, wrong=(1.01, 1.01)), "velocity"),
    "a sign": (shake(3.0, wrong=(1.0, -1.0)), "acceleration"),
    "after a kink only": (ramp(3.0, kinks=(0.5,)), "acceleration"),
    "velocity of another axis": (
        FunctionMotion(lambda t: [t, 0, 0], lambda t: [0, 1, 0], lambda t: [0, 0, 0]),
        "velocity",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_derivative_that_does_not_belong_is_reported_with_its_time(name):
    motion, which = WRONG[name]
    with pytest.raises(
        InputError, match=rf"its {which} is \[.* at t = [\d.e-]+ s, but its .* changes at the rate"
    ):
        check_derivatives(motion, np.arange(3), 0.0, 1.0)


def test_derivatives_are_asked_within_the_flight_never_across_a_break_and_only_along_driven_axes():
    asked = []
    u = along_x(lambda t: t, lambda t: asked.append(t) or 1.0, lambda t: 0.0)
    jumps = tuple(np.linspace(0.1, 0.9, 9))
    check_derivatives(
        FunctionMotion(u.displacement, u.velocity, u.acceleration, jumps), np.arange(3), 0.0, 1.0
    )
    assert 0.0 <= min(asked) < max(asked) <= 1.0
    junk = FunctionMotion(lambda t: [0, 0, np.exp(t)], lambda t: [0, 0, 7.0], lambda t: [0, 0, 7.0])
    check_derivatives(junk, np.array([0, 1]), 0.0, 1.0)
    with pytest.raises(InputError):
        check_derivatives(junk, np.array([2]), 0.0, 1.0)
