"""Signals and motions: values on both sides of jumps, declared kinks, tables against scipy and differences."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from netdae.errors import InputError
from netdae.motions import Fixed, FunctionMotion, TableMotion
from netdae.signals import Constant, Function, Pulse, Table, signal_of, times_within

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
def test_a_table_that_cannot_be_joined_is_told_with_its_row(times, values, words):
    with pytest.raises(InputError, match=words):
        Table(times, values)


def test_other_wrong_signals_are_told():
    with pytest.raises(InputError, match="quintic"):
        Table([0.0, 1.0], np.zeros((2, 3)), "quintic")
    with pytest.raises(InputError, match="end come after"):
        Pulse([1, 0, 0], 0.2, 0.1)
    with pytest.raises(InputError, match="three finite numbers"):
        Constant([1.0, 2.0])
    with pytest.raises(InputError, match=r"t = 0\.5 s.*three numbers"):
        Function(lambda t: [t, t])(0.5)


def test_times_within_are_strictly_inside_sorted_and_distinct():
    assert times_within([0.5, 0.0, 0.2, 0.5, 1.0], 0.0, 1.0) == [0.2, 0.5]


def check_derivatives(motion, t, h=1e-6):
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
        check_derivatives(motion, t)
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


def test_a_motion_by_functions_and_no_motion():
    motion = FunctionMotion(lambda t: [t**3, 0, 0], lambda t: [3 * t**2, 0, 0], lambda t: [6 * t, 0, 0])
    check_derivatives(motion, 0.7)
    assert not np.any(Fixed().at(3.0))
    assert Fixed().covers(-1e9, 1e9)


def test_wrong_motions_are_told():
    with pytest.raises(InputError, match="position cannot jump"):
        TableMotion([0.0, 1.0, 1.0, 2.0], np.zeros((4, 3)))
    with pytest.raises(InputError, match="leave them out"):
        TableMotion([0.0, 1.0], np.zeros((2, 3)), np.zeros((2, 3)), interpolation="linear")
