"""The condensed solve against scipy's solve of the whole Jacobian, and the calls of IDA that it rests on."""

import functools
import re
from dataclasses import dataclass

import numpy as np
import pytest
from conftest import SOFT, random_net, random_velocities, reference_flight
from scipy.sparse.linalg import spsolve

from netdae.core.errors import RunError
from netdae.forces.drawcord import drawcord
from netdae.forces.force import Account, Tangent
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.rings import Cord
from netdae.model.motions import FunctionMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.solvers import driver as integration
from netdae.solvers.flight import simulate
from netdae.solvers.ida.stepper import IdaSolver
from netdae.solvers.linalg.condensed import CondensedSolver, full_jacobian
from netdae.solvers.options import SolverOptions
from netdae.system.assembly import BlockPattern
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

SWING = FunctionMotion(
    lambda t: [0.1 * np.sin(t), 0.0, 0.0],
    lambda t: [0.1 * np.cos(t), 0.0, 0.0],
    lambda t: [-0.1 * np.sin(t), 0.0, 0.0],
)
DAMPINGS = {
    "none": NoDamping(),
    "rayleigh": Rayleigh(alpha=0.5, beta=1e-3),
    "dashpot": Dashpot(viscosity_time=1e-3),
}
RESTRAINTS = {
    "free": [],
    "held": [Restraint("one"), Restraint("few", axes="xz", motion=SWING)],
}


@dataclass(frozen=True, eq=False)
class Spring:
    """f = stiffness x on each node, towards the origin where it is negative, away from it where positive."""

    nodes: np.ndarray
    stiffness: float
    newton: str = "symmetric"
    jumps: tuple = ()
    kinks: tuple = ()
    external: bool = True

    def force(self, t, x, v):
        return self.stiffness * x

    def tangent(self, t, x, v):
        K = np.zeros((len(self.nodes), 1, 3, 1, 3))
        K[:, 0, range(3), 0, range(3)] = self.stiffness
        return Tangent.of_all(K, np.zeros_like(K))

    def account(self, t, x, v):
        return Account(external_power=float(np.vdot(self.stiffness * x, v)))


@pytest.fixture(params=DAMPINGS)
def damping(request):
    return DAMPINGS[request.param]


@pytest.fixture(params=RESTRAINTS)
def system(request, damping):
    return System(
        random_net(3),
        SOFT,
        damping=damping,
        masses={"few": 0.2},
        loads=[Gravity([0.0, 0.0, -9.81]), NodalLoad("few", lambda t: [t, 1.0, 0.0])],
        restraints=RESTRAINTS[request.param],
    )


def state_of(system):
    """Half of the cables taut, and slow enough that no dashpot is clamped by chance at a kink."""
    return system.net.nodes, random_velocities(system.net, size=0.3)


def dense_blocks(system, blocks):
    n = system.net.node_count
    dense = np.zeros((n, 3, n, 3))
    for i, j, block in zip(system.pattern.rows, system.pattern.columns, blocks, strict=True):
        dense[i, :, j, :], dense[j, :, i, :] = block, block.T
    return dense.reshape(3 * n, 3 * n)


def symmetrised_jacobian(system, x, v, cj):
    """J with the symmetric parts of T and D and with algebraic rows, written anew, dense."""
    T, D = (dense_blocks(system, b) for b in system.tangent_blocks(0.0, x, v))
    size = len(T)
    M = np.diag(np.repeat(system.mass, 3))
    J = np.block([[cj * np.eye(size), -np.eye(size)], [T, cj * M + D]])
    held = np.concatenate([system.restrained.ravel()] * 2)
    J[held] = np.eye(2 * size)[held]
    return J


def solved(system, x, v, right, cj, cj_setup=None):
    solver = CondensedSolver(system)
    solver.setup(system, 0.0, x, v, cj_setup or cj)
    result = np.empty((2, *x.shape))
    solver.solve(right[0], right[1], cj, result[0], result[1])
    return result


@pytest.mark.parametrize("cj", [1.0, 50.0, 3e3, 1e5])
def test_condensed_solve_is_the_solve_of_the_jacobian(system, cj):
    x, v = state_of(system)
    right = np.random.default_rng(5).standard_normal((2, *x.shape))
    result = solved(system, x, v, right, cj)
    J = symmetrised_jacobian(system, x, v, cj)
    if not isinstance(system.damping, Dashpot):  # then the whole Jacobian is symmetric in T and D
        np.testing.assert_allclose(full_jacobian(system, 0.0, x, v, cj).toarray(), J, rtol=0, atol=1e-10)
    expected = np.linalg.solve(J, right.ravel()).reshape(right.shape)
    # condition of K up to 1e5, where the masses count for little; dv is c_j times dx
    size = np.abs(expected[0]).max()
    np.testing.assert_allclose(result[0], expected[0], rtol=0, atol=1e-10 * size)
    np.testing.assert_allclose(result[1], expected[1], rtol=0, atol=1e-10 * max(cj * size, 1.0))


def test_condensed_solve_agrees_with_scipy_on_the_reference_net():
    system, start = reference_flight(4, damping=Rayleigh(beta=1e-5))
    x, cj = 2.6 * start.x, 1e4  # spread by 4 %: every cable is taut
    right = np.random.default_rng(5).standard_normal((2, *x.shape))
    expected = spsolve(full_jacobian(system, 0.0, x, start.v, cj).tocsc(), right.ravel())
    result = solved(system, x, start.v, right, cj).ravel()
    for part in (slice(None, x.size), slice(x.size, None)):
        error = np.abs(result[part] - expected[part]).max()
        assert error < 1e-10 * np.abs(expected[part]).max()  # condition of K is 1e4, of J 1e6


def test_another_cj_scales_the_free_part_and_leaves_restrained_axes_exact(system):
    x, v = state_of(system)
    right = np.random.default_rng(6).standard_normal((2, *x.shape))
    same, other = (solved(system, x, v, right, cj, cj_setup=100.0) for cj in (100.0, 120.0))
    held = system.restrained
    np.testing.assert_allclose(other[:, ~held], 2 / 2.2 * same[:, ~held], rtol=1e-12)
    np.testing.assert_array_equal(other[:, held], right[:, held])


@pytest.mark.parametrize("cj", [10.0, 3e3])
def test_jacobian_is_the_derivative_of_the_residual(system, cj):
    x, v = state_of(system)
    solver = IdaSolver(system, system.drive_from(x), SolverOptions())
    a = random_velocities(system.net, seed=1)

    def residual(y):
        """F along y + δ, ẏ + c_j δ: its derivative is J."""
        F = np.empty(y.size)
        y0 = np.concatenate((x.ravel(), v.ravel()))
        yp = np.concatenate((v.ravel(), a.ravel())) + cj * (y - y0)
        solver._residual(0.5, y, yp, F)
        return F

    y = np.concatenate((x.ravel(), v.ravel()))
    J = full_jacobian(system, 0.5, x, v, cj).toarray()
    h, products = 1e-6, np.empty(J.shape)
    for k in range(y.size):
        step = np.zeros(y.size)
        step[k] = h
        column = (residual(y + step) - residual(y - step)) / (2 * h)
        # by column: round-off of forces of 10 N over h, truncation h² EA/L³
        np.testing.assert_allclose(J[:, k], column, rtol=0, atol=1e-7 * max(1.0, np.abs(J[:, k]).max()))
        solver._true_product(0.5, y, None, None, step / h, products[k], cj)
    np.testing.assert_allclose(products.T, J, rtol=0, atol=1e-10)


@pytest.mark.parametrize("products", ["frozen", "true"])
def test_ida_calls_solve_product_solve(monkeypatch, products, without_rules_for_taut_cables):
    """What `ida.stepper` says that its frozen products rest on; another version of SUNDIALS may break it."""
    monkeypatch.setitem(integration._STEPPERS, "ida", ("netdae.solvers.ida.stepper", "IdaSolver"))
    calls = []

    def spy(name, letter):
        inner = getattr(IdaSolver, name)

        @functools.wraps(inner)  # sksundae reads the signature
        def call(self, *arguments):
            calls.append(letter)
            return inner(self, *arguments)

        monkeypatch.setattr(IdaSolver, name, call)

    spy("_residual", "r")
    spy("_setup", "p")
    spy("_solve", "s")
    spy("_frozen_product" if products == "frozen" else "_true_product", "j")
    system, start = reference_flight(3)
    flight = simulate(system, start, [0.0, 1.0], options=SolverOptions(products=products))
    order = "".join(calls)
    assert order.count("j") > 100
    if products == "frozen":
        # A lone solve is GMRES that finds the residual small enough: the correction is zero. Where Newton's
        # iteration runs off so far that rounding hides convergence, GMRES goes on in vain, up to five times.
        assert re.fullmatch(r"(rp?|s(js)*)*", order)
        assert order.count("sjsj") <= 0.01 * order.count("sjs")
        assert flight.statistics["solves"] == order.count("s") - order.count("j")
    else:
        # GMRES goes on where the frozen factor is not the true J: dashpots and a changed c_j make it poor often
        assert re.fullmatch(r"(rp?|s(js)*)*", order)
        assert order.count("sjsj") > 0.05 * order.count("sjs")
        assert flight.statistics["solves"] == order.count("s")
    assert flight.statistics["residuals"] == order.count("r")
    assert flight.statistics["setups"] == order.count("p")


def test_frozen_products_need_at_most_a_tenth_more_steps(monkeypatch, without_rules_for_taut_cables):
    """At standard; past the first snaps steps are a matter of chance, hence the sum over three starts."""
    monkeypatch.setitem(integration._STEPPERS, "ida", ("netdae.solvers.ida.stepper", "IdaSolver"))
    steps = {"frozen": 0, "true": 0}
    for seed in range(3):
        system, start = reference_flight(seed=seed)
        for products in steps:
            flight = simulate(system, start, [0.0, 0.45], options=SolverOptions(products=products))
            steps[products] += flight.statistics["steps"]
    assert steps["true"] > 2000
    assert steps["frozen"] < 1.1 * steps["true"]


def test_frozen_products_need_at_most_a_tenth_more_steps_with_rayleigh_damping(monkeypatch):
    monkeypatch.setitem(integration._STEPPERS, "ida", ("netdae.solvers.ida.stepper", "IdaSolver"))
    system, start = reference_flight(5, damping=Rayleigh(beta=1e-4))
    steps = {}
    for products in ("frozen", "true"):
        options = SolverOptions(products=products)
        steps[products] = simulate(system, start, [0.0, 1.0], options=options).statistics["steps"]
    assert steps["true"] > 200
    assert steps["frozen"] < 1.1 * steps["true"]


def test_negative_pivots_are_accepted():
    net = random_net(2)
    system = System(
        net, SOFT, damping=NoDamping(), forces=[Spring(np.arange(net.node_count)[:, None], 500.0)]
    )
    x, v = state_of(system)
    cj = 200.0
    K = cj**2 * system.mass_matrix().toarray() + system.tangent_matrix(x).toarray() - 500.0 * np.eye(x.size)
    assert np.linalg.eigvalsh(K).min() < -100.0
    assert np.linalg.eigvalsh(K).max() > 100.0
    right = np.random.default_rng(5).standard_normal((2, *x.shape))
    expected = np.linalg.solve(full_jacobian(system, 0.0, x, v, cj).toarray(), right.ravel())
    # condition of K below 1e4
    np.testing.assert_allclose(
        solved(system, x, v, right, cj).ravel(), expected, rtol=0, atol=1e-9 * np.abs(expected).max()
    )


def test_a_singular_matrix_is_reported():
    net = CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1]], rest_length=[2.0])  # slack
    cord = SOFT
    still = System(net, cord, damping=NoDamping(), masses={"all": 1.0})
    cj = 4.0  # its square and so the cancellation in K = c_j² m − k are exact
    system = System(
        net,
        cord,
        damping=NoDamping(),
        masses={"all": 1.0},
        forces=[Spring(np.arange(2)[:, None], float(cj**2 * still.mass[0]))],
    )
    with pytest.raises(RunError, match="singular"):
        CondensedSolver(system).setup(system, 0.0, net.nodes, np.zeros((2, 3)), cj)


def test_a_factorisation_after_a_failed_one_is_right():
    """A singular setup must not leave the solver unusable."""
    net = CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1]], rest_length=[2.0])
    still = System(net, SOFT, damping=NoDamping(), masses={"all": 1.0})
    system = System(
        net,
        SOFT,
        damping=NoDamping(),
        masses={"all": 1.0},
        forces=[Spring(np.arange(2)[:, None], float(16.0 * still.mass[0]))],
    )
    solver = CondensedSolver(system)
    zero = np.zeros((2, 3))
    solver.setup(system, 0.0, net.nodes, zero, 8.0)
    with pytest.raises(RunError, match="singular"):
        solver.setup(system, 0.0, net.nodes, zero, 4.0)
    solver.setup(system, 0.0, net.nodes, zero, 8.0)
    dx, dv = np.empty((2, 3)), np.empty((2, 3))
    solver.solve(zero, np.ones((2, 3)), 8.0, dx, dv)
    np.testing.assert_allclose(dx, 1 / (48.0 * still.mass[0]), rtol=1e-14)


def corded(k, *, friction, restraints=()):
    """A random net with two cords through its nodes, the first closed, and with a drum each, its last two nodes."""
    net = random_net(4, nodes=2 * k, cables=5 * k)
    x = np.concatenate((net.nodes, np.zeros((2, 3))))
    net = CableNet(
        x, net.cables, {**net.node_groups, "drums": [2 * k, 2 * k + 1]}, rest_length=net.rest_length
    )
    cords = []
    for rings, drum, closed in ((np.arange(k), 2 * k, True), (np.arange(k, 2 * k), 2 * k + 1, False)):
        way = np.linalg.norm(np.diff(x[[*rings, *rings[: int(closed)]]], axis=0), axis=1).sum()
        cord = Cord(0.9 * way, -1.0, 50.0, 0.0, False, 1e-3, 1e-2, friction, 0.3, 1.0)
        cords.append(drawcord(np.append(rings, drum)[None], cord, closed=closed))
    return System(
        net, SOFT, damping=NoDamping(), masses={"drums": 0.3}, restraints=restraints, forces=cords
    ), cords


@pytest.mark.parametrize("held", RESTRAINTS)
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_cords_through_many_rings_are_solved_whole_by_their_dyads(friction, held):
    """Both are taut, and their tangents unsymmetric by dashpot and friction: nothing of them is left out."""
    k = 8
    system, cords = corded(k, friction=friction, restraints=RESTRAINTS[held])
    x, v = system.net.nodes, random_velocities(system.net, size=0.3)
    rank = sum(len(cord.newton_part(0.0, x[cord.nodes], v[cord.nodes]).left) for cord in cords)
    assert rank == (4 if friction == 0 else 2 * k + 1)
    right = np.random.default_rng(5).standard_normal((2, *x.shape))
    for cj in (10.0, 3e3):
        result = solved(system, x, v, right, cj)
        J = full_jacobian(system, 0.0, x, v, cj).toarray()
        expected = np.linalg.solve(J, right.ravel()).reshape(right.shape)
        # condition of K up to 1e5, as above
        size = np.abs(expected[0]).max()
        np.testing.assert_allclose(result[0], expected[0], rtol=0, atol=1e-10 * size)
        np.testing.assert_allclose(result[1], expected[1], rtol=0, atol=1e-10 * max(cj * size, 1.0))


def test_a_cord_does_not_fill_the_factor():
    """Its blocks are those of a chain of cables: a factor with as many as those of such a chain has."""
    k = 40
    system, cords = corded(k, friction=0.0)
    chains = [np.stack((c.nodes[0, : c.parameters.segments], c.links[:, 1]), axis=1) for c in cords]
    chained = BlockPattern.of(system.net.node_count, [system.net.cables, *chains])
    np.testing.assert_array_equal(system.pattern.rows, chained.rows)
    np.testing.assert_array_equal(system.pattern.columns, chained.columns)
