"""A free target against Euler's equations and its invariants, by every kind of method, and a driven one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import netdae as nd

INERTIA = np.array([80.0, 120.0, 200.0])
MASS = 500.0
CORD = nd.Material(youngs_modulus=1e9, density=1390.0, diameter=1e-3)


def flown(spin, end, *, method="explicit", cells=2, frames=21, motion="free", inertia=INERTIA, **options):
    """A slack net at rest, and a target 5 m ahead that drifts and tumbles; the system and its flight."""
    net = nd.CableNet.square(side=1.0, cells=cells)
    target = nd.Target(
        (nd.Part(nd.Sphere(0.5)),),
        nd.RigidBody(MASS, inertia),
        motion=motion,
        position=(0.0, 0.0, 5.0),
        attitude=(0.5, 0.1, -0.7, 0.5),
        velocity=(0.1, -0.2, 0.05),
        spin=spin,
    )
    system = nd.System(net, CORD, damping=nd.NoDamping(), target=target)
    settings = nd.SolverOptions(method, **options)
    start = nd.State.at(net.nodes)
    return system, nd.simulate(system, start, np.linspace(0.0, end, frames), options=settings)


def spins(system, flight):
    """W at each frame, (k, 3), rad/s."""
    return flight.velocities[:, system.body.spin] / np.sqrt(system.body.target.body.inertia / MASS)


def invariants(system, flight):
    """Energy of rotation (k,) and angular momentum of the whole (k, 3)."""
    W = spins(system, flight)
    momentum = []
    for state in flight:
        system.take(state)
        momentum.append(system.angular_momentum(state.x, state.v))
    return 0.5 * W**2 @ system.body.target.body.inertia, np.array(momentum)


def axes_at(flight):
    return Rotation.from_quat(flight.attitudes, scalar_first=True)


# per method: relative errors of energy and angular momentum in one flip, a third of the demands for three of them
# (the place moves on a line by 560 000 sums, whose round-off is 7e-11 of the angular momentum)
KEPT = {"explicit": (3e-10, 2e-10), "ida": (3e-5, 1e-5)}


@pytest.mark.parametrize("method", KEPT)
def test_the_flip_of_an_intermediate_axis_keeps_energy_and_angular_momentum_beside_a_large_net(method):
    system, flight = flown((0.001, 1.0, 0.001), 28.0, method=method, cells=20, frames=81)
    energy, momentum = invariants(system, flight)
    W = spins(system, flight)
    assert W[0, 1] > 0.999
    assert W[:, 1].min() < -0.99  # it flips
    of_energy, of_momentum = KEPT[method]
    assert np.abs(energy / energy[0] - 1).max() < of_energy
    assert np.abs(momentum - momentum[0]).max() < of_momentum * np.linalg.norm(momentum[0])
    place = flight.positions[:, system.body.place]
    assert np.allclose(
        place, np.array([0, 0, 5]) + np.outer(flight.times, [0.1, -0.2, 0.05]), rtol=0, atol=1e-9
    )


def test_the_spin_follows_jacobis_elliptic_functions():
    """L. D. Landau and E. M. Lifshitz, Mechanics, section 37, for L² > 2 E I₂: W₁ ~ cn, W₂ ~ sn, W₃ ~ dn."""
    start = np.array([0.3, 0.0, 0.5])
    system, flight = flown(start, 10.0)
    one, two, three = INERTIA
    twice, square = INERTIA @ start**2, INERTIA**2 @ start**2
    assert square > twice * two
    rate = np.sqrt((three - two) * (square - twice * one) / (one * two * three))
    m = (two - one) * (twice * three - square) / ((three - two) * (square - twice * one))
    sn, cn, dn, _ = ellipj(rate * flight.times, m)
    amplitude = np.sqrt((twice * three - square) / (two * (three - two)))
    # I₂ Ẇ₂ = (I₃ − I₁) W₃ W₁ > 0 at the start
    expected = np.column_stack((start[0] * cn, amplitude * sn, start[2] * dn))
    assert rate * 10.0 > ellipk(m)  # more than a quarter of a period
    assert np.allclose(spins(system, flight), expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize(("method", "error"), [("explicit", 1e-8), ("ida", 2e-3), ("dop853", 1e-6)])
def test_the_attitude_follows_the_spin(method, error):
    """Against a quaternion integrated by SciPy at 1e-12."""
    start = np.array([0.3, 0.4, 0.5])
    system, flight = flown(start, 10.0, method=method)

    def rates(t, y):
        q, W = Rotation.from_quat(y[:4], scalar_first=True), y[4:]
        w, *u = q.as_quat(scalar_first=True)
        turned = np.concatenate(([-np.dot(u, W)], w * W + np.cross(u, W)))
        return np.concatenate((0.5 * turned, -np.cross(W, INERTIA * W) / INERTIA))

    first = np.concatenate((system.body.target.principal_attitude, start))
    truth = solve_ivp(rates, (0.0, 10.0), first, "DOP853", flight.times, rtol=1e-12, atol=1e-13)
    expected = Rotation.from_quat(truth.y[:4].T, scalar_first=True)
    assert (axes_at(flight) * expected.inv()).magnitude().max() < error
    assert np.allclose(np.linalg.norm(flight.attitudes, axis=1), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", ["explicit", "ida"])
def test_a_driven_target_turns_about_an_axis_of_its_own_at_a_constant_rate(method):
    spin = np.array([0.2, -0.3, 0.4])
    _, flight = flown(spin, 5.0, method=method, motion="moving")
    begin = axes_at(flight)[0]
    expected = begin * Rotation.from_rotvec(np.outer(flight.times, spin))
    assert (axes_at(flight) * expected.inv()).magnitude().max() < 1e-12


def test_a_target_of_spherical_inertia_spins_about_a_fixed_axis():
    spin = np.array([0.2, -0.3, 0.4])
    _, flight = flown(spin, 5.0, inertia=np.full(3, 80.0))
    expected = axes_at(flight)[0] * Rotation.from_rotvec(np.outer(flight.times, spin))
    assert (axes_at(flight) * expected.inv()).magnitude().max() < 1e-9


def test_a_flight_of_a_target_resumes_bit_for_bit():
    system, _ = flown((0.1, 0.2, 0.3), 0.1, frames=2)
    times, options = np.linspace(0.0, 1.0, 5), nd.SolverOptions("explicit")
    start = nd.State.at(nd.CableNet.square(side=1.0, cells=2).nodes)
    run = nd.integrate(system, start, times, options=options)
    for _ in range(3):
        next(run)
    memory = {name: np.array(value) for name, value in run.memory().items()}
    rest = list(run)
    again = list(nd.integrate(system, start, times, options=options, resume=memory))
    assert [state.t for state in rest] == [state.t for state in again]
    for one, other in zip(rest, again, strict=True):
        for name in ("x", "v", "a", "attitude"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name


def test_attitudes_are_kept_in_a_trajectory(tmp_path):
    _, flight = flown((0.1, 0.2, 0.3), 1.0, frames=4)
    flight.save(tmp_path / "trajectory.npz")
    loaded = nd.Trajectory.load(tmp_path)
    assert np.array_equal(loaded.attitudes, flight.attitudes)
    assert np.array_equal(loaded[2].attitude, flight[2].attitude)
    assert flight.attitudes.shape == (4, 4)


def test_the_nodes_of_a_target_are_not_the_nets():
    system, flight = flown((0.1, 0.2, 0.3), 0.1, frames=2)
    bare = nd.System(nd.CableNet.square(side=1.0, cells=2), CORD, damping=nd.NoDamping(), masses={"all": 0.1})
    beside = nd.System(
        nd.CableNet.square(side=1.0, cells=2),
        CORD,
        damping=nd.NoDamping(),
        masses={"all": 0.1},
        target=replace(system.body.target, velocity=(0.0, 0.0, 0.0)),
    )
    assert np.array_equal(beside.mass[:-2], bare.mass)
    assert beside.momentum(np.ones((len(beside.mass), 3)))[0] == pytest.approx(bare.mass.sum() + MASS)
    assert len(flight) == 2


def test_a_target_in_euler_angles_of_its_frame_is_seen_from_its_principal_axes():
    tensor = np.array([[3.0, 0.4, -0.2], [0.4, 2.5, 0.1], [-0.2, 0.1, 4.0]])
    body = nd.RigidBody.from_inertia(10.0, tensor, centre=(0.3, -0.2, 0.1))
    target = nd.Target((nd.Part(nd.Sphere(0.5)),), body, position=(1, 2, 3), attitude=(0.5, 0.1, -0.7, 0.5))
    principal, frame = target.principal_attitude, target.frame_of(target.principal_attitude)
    assert np.allclose(frame, target.attitude) or np.allclose(frame, -target.attitude)
    assert np.allclose(target.origin_of(target.centre, principal), (1, 2, 3))
    R, A = (Rotation.from_quat(q, scalar_first=True).as_matrix() for q in (principal, target.attitude))
    assert np.allclose(R @ np.diag(body.inertia) @ R.T, A @ tensor @ A.T)
