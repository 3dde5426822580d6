"""The paper's matrices against the compiled forces and against the paper's own words."""

import numpy as np
import pytest
from conftest import CORD, SOFT, random_net, random_velocities

from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

TOE = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, toe_strain=0.05)
LINEAR = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, law="engineering")


@pytest.fixture(params=range(4))
def net(request):
    return random_net(request.param)


@pytest.fixture(params=[SOFT, TOE, LINEAR], ids=["sharp", "toe", "engineering"])
def cord(request):
    return request.param


def by_blocks(system, blocks):
    """Dense (3n, 3n) of the symmetric blocks of a system's pattern."""
    n = system.net.node_count
    dense = np.zeros((n, 3, n, 3))
    for i, j, block in zip(system.pattern.rows, system.pattern.columns, blocks, strict=True):
        dense[i, :, j, :] = block
        dense[j, :, i, :] = block.T
    return dense.reshape(3 * n, 3 * n)


def test_secant_form_and_assembled_forces_agree(net, cord):
    """S(x) x of Eqs. (5), (8), against the forces that fly."""
    system = System(net, cord, damping=NoDamping())
    x = net.nodes
    strain = system.strain(x)
    assert (strain > 0).sum() > 5
    assert (strain < 0).sum() > 5
    f = system.force(0.0, x, random_velocities(net))
    np.testing.assert_allclose(
        -(system.secant_matrix(x) @ x.ravel()), f.ravel(), rtol=0, atol=1e-13 * np.abs(f).max()
    )


def test_secant_form_by_the_words_of_the_paper(net):
    """Eqs. (1) to (5), (8) cable by cable with dense matrices."""
    system = System(net, SOFT, damping=NoDamping())
    x = net.nodes + 0.01 * random_velocities(net)
    n, area, E = net.node_count, np.pi / 4 * 4e-6, 1e7
    S, T = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, 3 * n))
    identity = np.eye(3)
    Delta = np.block([[identity, -identity], [-identity, identity]])
    for (i, j), L in zip(net.cables, net.rest_length, strict=True):
        A = np.zeros((6, 3 * n))
        A[:3, 3 * i : 3 * i + 3] = A[3:, 3 * j : 3 * j + 3] = identity
        xe = A @ x.ravel()
        E11 = 0.5 * (xe @ Delta @ xe - L**2) / L**2
        S11, slope = (E * E11, E) if E11 >= 0 else (0.0, 0.0)
        Se = S11 * area / L * Delta
        S += A.T @ Se @ A
        T += A.T @ (Se + slope * area / L**3 * np.outer(Delta @ xe, Delta @ xe)) @ A
    scale = np.abs(T).max()
    np.testing.assert_allclose(system.secant_matrix(x).toarray(), S, rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(system.tangent_matrix(x).toarray(), T, rtol=0, atol=1e-13 * scale)


def test_tangent_matrix_and_assembled_tangents_agree(net, cord):
    system = System(net, cord, damping=NoDamping())
    T, D = system.tangent_blocks(0.0, net.nodes, random_velocities(net))
    paper = system.tangent_matrix(net.nodes).toarray()
    np.testing.assert_allclose(by_blocks(system, T), paper, rtol=0, atol=1e-13 * np.abs(paper).max())
    assert not D.any()


def test_tangent_matrix_is_the_derivative_of_the_secant_form(net, cord):
    system = System(net, cord, damping=NoDamping())
    x, h = net.nodes, 1e-6
    differences = np.empty((x.size, x.size))
    for k in range(x.size):
        step = np.zeros(x.size)
        step[k] = h
        up, down = x + step.reshape(x.shape), x - step.reshape(x.shape)
        differences[:, k] = (
            system.secant_matrix(up) @ up.ravel() - system.secant_matrix(down) @ down.ravel()
        ) / (2 * h)
    T = system.tangent_matrix(x).toarray()
    # round-off 1e-16/h, truncation h² times third derivatives: 1e-10, 1e-12/ε² with the toe
    np.testing.assert_allclose(T, differences, rtol=0, atol=1e-8 * np.abs(T).max())


def test_secant_and_tangent_are_symmetric_and_know_no_rigid_motion(net, cord):
    system = System(net, cord, damping=NoDamping())
    shift = np.tile(np.eye(3), (net.node_count, 1))
    for matrix in (system.secant_matrix(net.nodes), system.tangent_matrix(net.nodes)):
        dense = matrix.toarray()
        np.testing.assert_allclose(dense, dense.T, rtol=0, atol=1e-14 * np.abs(dense).max())
        assert np.linalg.eigvalsh(dense).min() > -1e-12 * np.abs(dense).max()  # taut cables only
        np.testing.assert_allclose(dense @ shift, 0.0, atol=1e-13 * np.abs(dense).max())


def test_mass_matrix_is_half_of_each_cable_and_the_bullets(net):
    system = System(net, SOFT, damping=NoDamping(), masses={"few": 0.3})
    expected = np.zeros(net.node_count)
    for (i, j), L in zip(net.cables, net.rest_length, strict=True):
        expected[[i, j]] += 0.5 * 1000.0 * np.pi / 4 * 4e-6 * L
    expected[[1, 4, 7]] += 0.3
    np.testing.assert_allclose(system.mass, expected, rtol=1e-13)
    np.testing.assert_allclose(system.mass_matrix().diagonal(), np.repeat(expected, 3), rtol=1e-13)
    whole = 1000.0 * np.pi / 4 * 4e-6 * net.rest_length.sum() + 0.9
    assert system.mass.sum() == pytest.approx(whole, rel=1e-13)


def test_rayleigh_forces_are_the_damping_matrix_times_velocity(net, cord):
    system = System(net, cord, damping=Rayleigh(alpha=0.7, beta=1e-3), masses={"few": 0.3})
    still = System(net, cord, damping=NoDamping(), masses={"few": 0.3})
    v = random_velocities(net)
    x = 0.5 * net.nodes  # all slack: Eq. (9) asks x̄ alone
    damping = system.force(0.0, x, v) - still.force(0.0, x, v)
    D = system.damping_matrix()
    np.testing.assert_allclose(-(D @ v.ravel()), damping.ravel(), rtol=0, atol=1e-13 * np.abs(damping).max())
    _, blocks = system.tangent_blocks(0.0, x, v)
    np.testing.assert_allclose(by_blocks(system, blocks), D.toarray(), rtol=0, atol=1e-13 * np.abs(D).max())
    assert system.account(0.0, x, v)[1] == pytest.approx(v.ravel() @ (D @ v.ravel()), rel=1e-13)


def test_eq_9_is_the_tangent_of_an_unstrained_sharp_net():
    net = CableNet.square(side=5.0, cells=4)
    system = System(net, CORD, damping=Rayleigh(beta=1.0))
    # strains of exactly 0 or of one rounding belong to the taut branch only by luck: stretch by 1e-9
    T = system.tangent_matrix(net.nodes * (1 + 1e-9)).toarray()
    K0 = system.damping_matrix().toarray()
    np.testing.assert_allclose(K0, T, rtol=0, atol=1e-8 * np.abs(T).max())


def test_eq_9_asks_neither_toe_nor_law_and_takes_lengths_from_rest_length():
    net = random_net(1)
    one, other = (System(net, cord, damping=Rayleigh(beta=1.0)).damping_matrix() for cord in (TOE, LINEAR))
    assert abs(one - other).max() == 0.0
    area, (i, j), L = np.pi / 4 * 4e-6, net.cables[3], net.rest_length[3]
    span = net.nodes[j] - net.nodes[i]
    n = span / np.linalg.norm(span)
    block = one.toarray()[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
    np.testing.assert_allclose(block, -1e7 * area / L * np.outer(n, n), rtol=1e-12)


def test_tangents_with_the_dashpot_enter_by_their_symmetric_part(net):
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-2))
    x, v = net.nodes, 0.1 * random_velocities(net)
    n = net.node_count
    whole = np.empty((2, 3 * n, 3 * n))
    for k in range(3 * n):
        unit = np.zeros(3 * n)
        unit[k] = 1.0
        unit, zero = unit.reshape(n, 3), np.zeros((n, 3))
        whole[0, :, k] = -system.tangent_product(0.0, x, v, unit, zero).ravel()
        whole[1, :, k] = -system.tangent_product(0.0, x, v, zero, unit).ravel()
    T, D = system.tangent_blocks(0.0, x, v)
    scale = np.abs(whole[0]).max()
    assert np.abs(whole[0] - whole[0].T).max() > 1e-4 * scale  # d ⊗ w is there
    np.testing.assert_allclose(
        by_blocks(system, T), 0.5 * (whole[0] + whole[0].T), rtol=0, atol=1e-13 * scale
    )
    np.testing.assert_allclose(by_blocks(system, D), whole[1], rtol=0, atol=1e-13 * np.abs(whole[1]).max())
