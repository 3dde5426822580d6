"""Every force against differences: tangents on both sides of every branch, energies, powers.

A new force joins by one line in `CASES`; `test_every_law_is_tested_here` asks for it.
"""

import importlib
import pkgutil

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import netdae.forces
from netdae.core.records import Record
from netdae.forces.air import AIR, AirOnCables
from netdae.forces.brake import BRAKE, END_STOP, Brake, EndStop
from netdae.forces.cables import CABLE, Cables, law_of
from netdae.forces.contact import MEETING, RESTING, Meeting, Resting
from netdae.forces.drag import BODY_DRAG, DragOnBodies
from netdae.forces.drawcord import DRAWCORD, drawcord
from netdae.forces.elements import ElementForce
from netdae.forces.free_molecular import MOLECULAR_DRAG, MolecularDrag
from netdae.forces.gyroscope import GYROSCOPE, Gyroscope
from netdae.forces.law import LAWS
from netdae.forces.loads import uniform_load
from netdae.forces.motor import MOTOR, Motor
from netdae.forces.orbit import ORBIT, OrbitForce
from netdae.forces.pose import pose_of
from netdae.forces.rayleigh import MASS_DAMPING, STIFFNESS_DAMPING, MassDamping, StiffnessDamping
from netdae.forces.reel import REELED, Reeled
from netdae.forces.rings import Cord
from netdae.forces.solar import LIGHT, Light, LightOnCables
from netdae.forces.spring import GROUND_SPRING, STRUT, GroundSpring, Strut
from netdae.model.shapes.distance import curvatures
from netdae.model.shapes.hull import ConvexHull
from netdae.model.shapes.part import Part, parts_of
from netdae.model.shapes.solids import Box, Capsule, Cone, Cylinder, Sphere
from netdae.model.signals import CLOCK, Constant, Function
from netdae.system.damping import Dashpot

M = 20  # elements in each case
EPS = 0.2  # toe strain, as large as the strains, so that each branch is well away from its ends


def random_cables(strain, rate, *, eps=0.0, engineering=False, tau=0.0):
    """Random cables with strains and strain rates in the given ranges, and sideways motion of 1 m/s; their x and v."""
    rng = np.random.default_rng(7)
    L, EA = rng.uniform(0.5, 1.5, M), rng.uniform(20.0, 60.0, M)
    E11, dE11 = rng.uniform(*strain, M), rng.uniform(*rate, M)
    n = rng.standard_normal((M, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    d = n * (L * np.sqrt(1 + 2 * E11))[:, None]
    side = rng.standard_normal((M, 3))
    w = side - np.sum(side * n, axis=1)[:, None] * n + d * (dE11 * L**2 / np.sum(d * d, axis=1))[:, None]
    x, v = rng.standard_normal((M, 2, 3)), rng.standard_normal((M, 2, 3))
    x[:, 1], v[:, 1] = x[:, 0] + d, v[:, 0] + w
    nodes = np.arange(2 * M).reshape(M, 2)
    return Cables(nodes, L, EA, np.full(M, eps), np.full(M, engineering), np.full(M, tau)), x, v


def cables(strain, rate, **more):
    held, x, v = random_cables(strain, rate, **more)
    return held.force, 0.0, x, v


def reeled(strain, rate, *, eps=0.0, engineering=False, tau=0.0):
    """Random cables on reels that run at 1 m/s, with strains and strain rates in the given ranges."""
    held, x, v = random_cables(strain, rate, eps=eps, engineering=engineering, tau=tau)
    rng = np.random.default_rng(10)
    share, s = rng.choice([1.0, -1.0, 0.5], M), rng.uniform(-0.3, 0.3, M)
    x, v = (np.concatenate((a, rng.standard_normal((M, 1, 3))), axis=1) for a in (x, v))
    x[:, 2, 0] = s
    d = x[:, 1] - x[:, 0]
    # undoes the reel's part of the strain rate, −σ Λ ṡ/L̄
    v[:, 1] += d * (share * v[:, 2, 0] / held.L)[:, None]
    nodes = np.arange(3 * M).reshape(M, 3)
    cords = held.EA, held.eps, held.engineering, held.tau
    return ElementForce(REELED, nodes, Reeled(held.L - share * s, share, *cords)), 0.0, x, v


def strung(strain, rate, *, closed=True, eps=0.0, engineering=False, tau=0.0, friction=0.0, theta=1.0):
    """A cord through six random rings of 0.1 m, whose strain and strain rate are in the middle of the given ranges."""
    rng = np.random.default_rng(12)
    k, size, EA, share = 6, 0.1, 50.0, -0.7
    E11, dE11 = np.mean(strain), np.mean(rate)
    x, v = rng.standard_normal((2, 1, k + 1, 3))
    ends = np.stack((np.arange(k), (np.arange(k) + 1) % k), axis=1)[: k if closed else -1]
    d, w = (values[0, ends[:, 1]] - values[0, ends[:, 0]] for values in (x, v))
    h = np.sqrt(np.sum(d * d, axis=1) + size**2)
    length, rate_of = h.sum(), np.sum(np.sum(d * w, axis=1) / h)
    L = length / np.sqrt(1 + 2 * E11)
    v[0, k, 0] = L / share * (length * rate_of / L**2 - dE11) / (1 + 2 * E11)
    cord = Cord(L - share * x[0, k, 0], share, EA, eps, engineering, tau, size, friction, 2.0, theta)
    return drawcord(np.arange(k + 1)[None], cord, closed=closed), 0.0, x, v


def points(make):
    rng = np.random.default_rng(8)
    nodes = np.arange(M)[:, None]
    force = make(nodes, rng.uniform(0.1, 1.0, M))
    return force, 0.3, rng.standard_normal((M, 1, 3)), rng.standard_normal((M, 1, 3))


def drums(make, *, x=(-1.0, 1.0), v=(-1.0, 1.0)):
    """`make(nodes, a, b)` with a and b in [0.1, 1], at nodes whose x and v along x are in the given ranges."""
    rng = np.random.default_rng(11)
    force = make(np.arange(M)[:, None], *rng.uniform(0.1, 1.0, (2, M)))
    places, rates = rng.standard_normal((2, M, 1, 3))
    places[:, 0, 0], rates[:, 0, 0] = rng.uniform(*x, M), rng.uniform(*v, M)
    return force, 0.0, places, rates


def brake(*, ratchet=False, **more):
    def make(nodes, a, b):
        return ElementForce(BRAKE, nodes, Brake(a, np.full(M, 0.5), b, np.full(M, ratchet)))

    return drums(make, **more)


def motor(**more):
    return drums(
        lambda nodes, F, v: ElementForce(MOTOR, nodes, Motor(F, v, 0.5 * v, np.full(M, 0.3))), **more
    )


def end_stop(side, **more):
    """Stops at ± 0.5 m with 0.1 to 1 N/m and 0.1 to 1 N s/m."""

    def make(nodes, k, c):
        return ElementForce(END_STOP, nodes, EndStop(np.full(M, 0.5 * side), np.full(M, side), k, c))

    return drums(make, **more)


def in_a_stream(make, strain):
    """`make(nodes, L, weight, stream)` on random cables with strains in the given range."""
    held, x, v = random_cables(strain, (-1.0, 1.0))
    return make(held.nodes, held.L, np.linspace(0.1, 1.0, M), Constant([0.3, -2.0, 1.0])), 0.0, x, v


def in_air(strain):
    return in_a_stream(
        lambda nodes, L, c, wind: ElementForce(AIR, nodes, AirOnCables(L, c, 0.3 * c), wind), strain
    )


def in_light(strain):
    return in_a_stream(
        lambda nodes, L, c, sun: ElementForce(LIGHT, nodes, LightOnCables(L, c), Light(sun)), strain
    )


def in_thin_air(strain):
    return in_a_stream(
        lambda nodes, L, c, stream: ElementForce(MOLECULAR_DRAG, nodes, MolecularDrag(L, c), stream), strain
    )


def drag_of_bodies():
    wind = Constant([0.3, -2.0, 1.0])
    return points(lambda nodes, c: ElementForce(BODY_DRAG, nodes, DragOnBodies(c), wind))


def load():
    changing = Function(lambda t: [t, t * t, 1.0 - t])
    return points(lambda nodes, w: uniform_load(nodes[:, 0], w, changing))


def stiffness_damping():
    _, _, x, v = cables((-0.1, 0.1), (-1.0, 1.0))
    A = np.random.default_rng(9).standard_normal((M, 3))
    damping = StiffnessDamping(A)
    return ElementForce(STIFFNESS_DAMPING, np.arange(2 * M).reshape(M, 2), damping), 0.0, x, v


def struts():
    """Pulled out and pushed in by a third."""
    of_cables, _, x, v = cables((-0.3, 0.5), (-1.0, 1.0))
    rng = np.random.default_rng(13)
    k, c, L = rng.uniform(0.1, 1.0, (3, M))
    return ElementForce(STRUT, of_cables.nodes, Strut(k, c, L)), 0.0, x, v


def ground_springs(nodes, k, L):
    anchor = np.random.default_rng(14).standard_normal((M, 3))
    parameters = GroundSpring(k, 0.3 * k, np.full(M, L), anchor)
    return ElementForce(GROUND_SPRING, nodes, parameters)


RIGID = {
    "sphere": Sphere(1.0),
    "capsule": Capsule(0.5, 2.0),
    "box": Box([1.0, 1.4, 1.8], rounding=0.3),
    "cylinder": Cylinder(0.8, 1.6, rounding=0.4),
    "cone": Cone(0.9, 0.4, 1.5, rounding=0.2),
    "hull": ConvexHull(np.random.default_rng(3).standard_normal((12, 3)), rounding=0.3),
}
POSES = []  # records that cases refer to


def bodies_near(shape, depth, slip, *, knots=False, exponent=1.0, dissipation=0.0, friction=0.0, fixed=False):
    """Cables, or knots, about as deep as `depth` in a body that moves; u·g of about `slip`."""
    rng = np.random.default_rng(15)
    part = Part(RIGID[shape], position=(0.1, -0.2, 0.3), attitude=(0.8, 0.1, -0.3, 0.5))
    parts = Record(parts_of([part]))
    q = np.array([0.5, 0.3, -0.6, 0.4])
    R = Rotation.from_quat(q, scalar_first=True)
    rho = np.array([0.4, 0.6, 0.5])
    spun = rng.uniform(-0.5, 0.5, 3)
    base = pose_of(q / np.linalg.norm(q), rho, 2.0, free=True)
    place, V = rng.standard_normal((2, 3))
    if fixed:
        R, place, V, spun = Rotation.identity(), np.zeros(3), np.zeros(3), np.zeros(3)
    base.base[4:7], base.base[7:10] = 0.3, spun
    POSES.extend((parts, pose := Record(base)))
    b, n = [], []
    while len(b) < M:
        towards = rng.standard_normal(3)
        towards /= np.linalg.norm(towards)
        b.append(part.position + _way_out(parts, part.position, towards, depth) * towards)
        n.append(curvatures(*_of(parts), b[-1][None])[0, 1:4])
    b, n = np.array(b), np.array(n)
    across = np.cross(n, rng.standard_normal((M, 3))) * (0.0 if knots else 0.4)
    tilt = n * (0.0 if knots else 0.02) * rng.uniform(-1, 1, (M, 1))
    share = rng.uniform(0.3, 0.6, (M, 1))
    ends = np.stack((b - share * across - tilt, b + (1 - share) * across + tilt), axis=1)
    x = R.apply(ends.reshape(-1, 3)).reshape(M, 2, 3) + place
    slide = np.cross(n, rng.standard_normal((M, 3))) + slip * n + np.cross(spun, b)
    v = (R.apply(slide) + V)[:, None] + 0.1 * rng.standard_normal((M, 2, 3)) * (not knots)
    if knots:
        x[:, 1], v[:, 1] = x[:, 0], v[:, 0]
    ones = np.ones(M)
    values = {
        "part": np.zeros(M, dtype=np.int64),
        "radius": 0.01 * ones,
        "regular": (0.0 if knots else 0.1) * ones,
        "stiffness": rng.uniform(20.0, 60.0, M),
        "exponent": exponent * ones,
        "dissipation": dissipation * ones,
        "friction": friction * ones,
        "slip_speed": 0.5 * ones,
        "convex": parts.values.convex[np.zeros(M, dtype=np.int64)],
        "lipschitz": ones,
        "place": 0.5 * ones,
        "met": np.zeros((M, 11)),
        "elastic": False,
        "exact": True,
        "middle": parts.values.centre[np.zeros(M, dtype=np.int64)],
        "sphere": np.full(M, parts.values.radius[0]),
        "asleep": np.zeros(M),
        "way": 0,
    }
    if fixed:
        nodes = np.arange(2 * M).reshape(M, 2)
        return ElementForce(RESTING, nodes, Resting(parts.address, **values)), 0.0, x, v
    x, v = (np.concatenate((a, np.zeros((M, 2, 3))), axis=1) for a in (x, v))
    x[:, 2], v[:, 2], x[:, 3], v[:, 3] = place, V, 0.3 * rho, spun * rho
    nodes = np.arange(4 * M).reshape(M, 4)
    return ElementForce(MEETING, nodes, Meeting(parts.address, pose.address, **values), CLOCK), 0.0, x, v


def _way_out(parts, begin, towards, depth):
    """How far it is to the depth, in a direction."""
    return brentq(lambda s: curvatures(*_of(parts), (begin + s * towards)[None])[0, 0] + depth, 0, 4)


def _of(parts):
    p = parts.values
    return p.kind[0], p.first[0], p.numbers


def toe(strain, rate=(-1.0, 1.0), **more):
    return lambda: cables(strain, rate, eps=EPS, **more)


SLACK, TAUT, IN_TOE, ABOVE = (-0.4, -0.02), (0.02, 0.5), (0.02, 0.9 * EPS), (1.1 * EPS, 0.6)
# with τ = 0.1 s the dashpot adds 0.1 Ė11 g′: rates over −0.1 leave S11 > 0 at strains over 0.02, see the check below
ACTIVE, CLAMPED, TAU = (0.0, 2.0), (-40.0, -20.0), 0.1
LINEAR = {"engineering": True}

CASES = {
    "slack": lambda: cables(SLACK, (-1.0, 1.0)),
    "slack toe": toe(SLACK),
    "slack engineering": toe(SLACK, **LINEAR),
    "slack dashpot": toe(SLACK, (-40.0, 40.0), tau=TAU),
    "taut": lambda: cables(TAUT, (-1.0, 1.0)),
    "in the toe": toe(IN_TOE),
    "above the toe": toe(ABOVE),
    "taut engineering": lambda: cables(TAUT, (-1.0, 1.0), **LINEAR),
    "in the toe engineering": toe((0.02, 0.9 * EPS), **LINEAR),
    "above the toe engineering": toe((1.3 * EPS, 0.6), **LINEAR),  # λ − 1 < E11: the branch is at E11 = 0.22
    "taut dashpot": lambda: cables(TAUT, ACTIVE, tau=TAU),
    "taut dashpot unloading": lambda: cables((0.3, 0.5), (-2.0, -1.0), tau=TAU),
    "in the toe dashpot": toe(IN_TOE, ACTIVE, tau=TAU),
    "above the toe dashpot": toe(ABOVE, ACTIVE, tau=TAU),
    "taut engineering dashpot": lambda: cables(TAUT, ACTIVE, tau=TAU, **LINEAR),
    "in the toe engineering dashpot": toe(IN_TOE, ACTIVE, tau=TAU, **LINEAR),
    "above the toe engineering dashpot": toe((1.3 * EPS, 0.6), ACTIVE, tau=TAU, **LINEAR),
    "taut dashpot clamped": lambda: cables(TAUT, CLAMPED, tau=TAU),
    "in the toe dashpot clamped": toe(IN_TOE, CLAMPED, tau=TAU),
    "above the toe engineering dashpot clamped": toe((1.3 * EPS, 0.6), CLAMPED, tau=TAU, **LINEAR),
    "reeled slack": lambda: reeled(SLACK, (-1.0, 1.0), tau=TAU),
    "reeled taut": lambda: reeled(TAUT, (-1.0, 1.0)),
    "reeled in the toe engineering": lambda: reeled(IN_TOE, (-1.0, 1.0), eps=EPS, **LINEAR),
    "reeled taut dashpot": lambda: reeled(TAUT, ACTIVE, tau=TAU),
    "reeled taut dashpot unloading": lambda: reeled((0.3, 0.5), (-2.0, -1.0), tau=TAU),
    "reeled in the toe dashpot": lambda: reeled(IN_TOE, ACTIVE, eps=EPS, tau=TAU),
    "reeled above the toe engineering dashpot": lambda: reeled((1.3 * EPS, 0.6), ACTIVE, eps=EPS, tau=TAU, **LINEAR),
    "reeled taut dashpot clamped": lambda: reeled(TAUT, CLAMPED, tau=TAU),
    "brake": brake,
    "brake with a ratchet paying out": lambda: brake(ratchet=True, v=(0.01, 1.0)),
    "brake with a ratchet winding back": lambda: brake(ratchet=True, v=(-1.0, -0.01)),
    "end stop not reached": lambda: end_stop(1.0, x=(-0.5, 0.49)),
    "end stop above": lambda: end_stop(1.0, x=(0.6, 1.0), v=(-0.005, 1.0)),  # k δ ≥ 0.01 N, c δ̇ ≥ −0.005 N
    "end stop below": lambda: end_stop(-1.0, x=(-1.0, -0.6), v=(-1.0, 0.005)),
    "end stop let go": lambda: end_stop(1.0, x=(0.6, 1.0), v=(-40.0, -20.0)),  # k δ ≤ 0.5 N, c δ̇ ≤ −2 N
    "motor winding in": lambda: motor(v=(0.01, 1.0)),
    "motor pulled back": lambda: motor(v=(-1.0, -0.01)),
    "drawcord slack": lambda: strung(SLACK, (-1.0, 1.0), tau=TAU, friction=0.3),
    "drawcord taut": lambda: strung(TAUT, (-1.0, 1.0)),
    "drawcord open in the toe engineering": lambda: strung(IN_TOE, (-1.0, 1.0), closed=False, eps=EPS, **LINEAR),
    "drawcord taut dashpot": lambda: strung(TAUT, ACTIVE, tau=TAU),
    "drawcord open taut dashpot unloading": lambda: strung((0.3, 0.5), (-2.0, -1.0), closed=False, tau=TAU),
    "drawcord in the toe dashpot": lambda: strung(IN_TOE, ACTIVE, eps=EPS, tau=TAU),
    "drawcord taut dashpot clamped": lambda: strung(TAUT, CLAMPED, tau=TAU, friction=0.3),
    "drawcord with friction": lambda: strung(TAUT, (-1.0, 1.0), friction=0.3),
    "drawcord with friction and dashpot at both ends": lambda: strung(
        TAUT, ACTIVE, tau=TAU, friction=0.3, theta=0.5
    ),
    "drawcord open with friction above the toe engineering dashpot": lambda: strung(
        (1.3 * EPS, 0.6), ACTIVE, closed=False, eps=EPS, tau=TAU, friction=0.5, **LINEAR
    ),
    "orbit": lambda: points(lambda nodes, m: ElementForce(ORBIT, nodes, OrbitForce(m, 0.7))),
    "drag of bodies": drag_of_bodies,
    "molecular drag slack": lambda: in_thin_air(SLACK),
    "molecular drag taut": lambda: in_thin_air(TAUT),
    "air slack": lambda: in_air(SLACK),
    "air taut": lambda: in_air(TAUT),
    "light slack": lambda: in_light(SLACK),
    "light taut": lambda: in_light(TAUT),
    "stiffness damping": stiffness_damping,
    "struts": struts,
    "springs to the ground": lambda: points(lambda nodes, k: ground_springs(nodes, k, 0.7)),
    "springs to the ground without length": lambda: points(lambda nodes, k: ground_springs(nodes, k, 0.0)),
    "mass damping": lambda: points(lambda nodes, c: ElementForce(MASS_DAMPING, nodes, MassDamping(c))),
    "load": load,
    "gyroscope": lambda: points(
        lambda nodes, m: ElementForce(GYROSCOPE, nodes, Gyroscope(np.linspace([0.3, 0.4, 0.5], [0.6, 0.5, 0.8], M), m))
    ),
    "body out of reach": lambda: bodies_near("box", -0.1, -1.0),
    "knots on a body": lambda: bodies_near("sphere", 0.02, -0.5, knots=True, dissipation=0.3, friction=0.4),
    "knots on a fixed body": lambda: bodies_near("box", 0.02, -0.5, knots=True, fixed=True, friction=0.4),
    "cables on a fixed body": lambda: bodies_near("cylinder", 0.02, -0.5, dissipation=0.3, friction=0.4, fixed=True),
    "cables leaving a body that holds no more": lambda: bodies_near(
        "capsule", 0.05, 9.0, dissipation=1.0, friction=0.4
    ),
    **{
        f"cables on a {shape}": lambda shape=shape: bodies_near(
            shape, 0.12, -0.5, exponent=1.5, dissipation=0.3, friction=0.4
        )
        for shape in RIGID
    },
}  # fmt: skip


@pytest.fixture(params=CASES)
def case(request):
    return CASES[request.param]()


def differences(function, place, h):
    """Central differences of function(place) (m, k, 3) by each node and axis: (m, k, 3, k, 3)."""
    m, k, _ = place.shape
    result = np.empty((m, k, 3, k, 3))
    for j in range(k):
        for b in range(3):
            step = np.zeros_like(place)
            step[:, j, b] = h
            result[..., j, b] = (function(place + step) - function(place - step)) / (2 * h)
    return result


def all_laws():
    """Those whose parameters are of a module of netdae.forces."""
    package = netdae.forces.__name__
    for info in pkgutil.iter_modules(netdae.forces.__path__):
        importlib.import_module(f"{package}.{info.name}")
    laws = {law for kind, law in LAWS.items() if kind.__module__.startswith(f"{package}.")}
    assert laws
    return laws


def test_every_law_is_tested_here():
    tested = {make()[0].law for make in CASES.values()}
    for law in all_laws():
        assert law in tested, f"{law.parameters.__name__} has no line in CASES"


def test_what_acts_inside_a_net_keeps_its_momentum():
    """Pairs whatever they do, and all laws that are not external; drums of reels are no places in space."""
    acting = set()
    for name, make in CASES.items():
        force, t, x, v = make()
        law = force.law
        f = force.force(t, x, v)
        size = np.abs(f).max()
        if size > 0:
            acting.add(law)
        if law.pair:
            assert (np.abs(f[:, 0] + f[:, 1]) <= 1e-12 * size).all(), name
        if not (law.external or law.implicit or law is GYROSCOPE):  # which act on drums, or a spin, alone
            in_space = f[:, :-1] if law in (REELED, DRAWCORD, MEETING) else f
            assert (np.abs(in_space.sum(axis=1)) <= 1e-12 * size).all(), name
    assert acting == all_laws()


def test_tangents_are_the_derivatives_of_the_force(case):
    force, t, x, v = case
    K, C = force.tangent(t, x, v).spread(len(x))
    # h = 1e-5: round-off 1e-16/h = 1e-11 and truncation h² = 1e-10 of the force's third derivative, which is
    # up to 1/EPS² = 25 times the tangent in the toe
    h = 1e-5
    Kd = differences(lambda at: force.force(t, at, v), x, h)
    Cd = differences(lambda at: force.force(t, x, at), v, h)
    scale = max(np.abs(Kd).max(), np.abs(Cd).max(), 1.0)
    if force.law is MEETING:
        scale *= 3.0  # the point of a cable that touches a rounded edge moves: the third derivative is larger
    np.testing.assert_allclose(K, Kd, rtol=0, atol=1e-8 * scale)
    np.testing.assert_allclose(C, Cd, rtol=0, atol=1e-8 * scale)


def test_the_elastic_force_is_minus_the_gradient_of_the_stored_energy(case):
    force, t, x, v = case
    stores = force.law.energy is not None  # loads and motors push at rest, and store nothing
    at_rest = force.force(t, x, np.zeros_like(v)) * stores
    h = 1e-5  # as above
    gradient = np.empty_like(x)
    for index in np.ndindex(x.shape):
        step = np.zeros_like(x)
        step[index] = h
        up, down = (force.account(t, x + s, np.zeros_like(v)).stored_energy for s in (step, -step))
        gradient[index] = (up - down) / (2 * h)
    # the energy of all M cables, some 50 J, is rounded: 1e-14/h; on a rounded edge h² of the third derivative is more
    np.testing.assert_allclose(-gradient, at_rest, rtol=0, atol=5e-7 if force.law is MEETING else 1e-7)


def test_stored_dissipated_and_external_power_balance_the_force(case):
    force, t, x, v = case
    account = force.account(t, x, v)
    h = 1e-6  # along x + v h, |v| ~ 1 to 40 m/s
    up, down = (force.account(t, x + s * v, v).stored_energy for s in (h, -h))
    power = float(np.vdot(force.force(t, x, v), v))
    balance = (up - down) / (2 * h) + account.dissipated_power + power - account.external_power
    assert abs(balance) < 1e-6 * max(1.0, abs(power), account.dissipated_power)
    assert account.dissipated_power >= 0.0


def test_the_cases_lie_on_the_branches_they_name():
    for name, make in CASES.items():
        force, _, x, v = make()
        if force.law not in (CABLE, REELED):
            continue
        reported = force.parameters
        L = reported.L + reported.share * x[:, 2, 0] if force.law is REELED else np.sqrt(reported.L2)
        pull = np.linalg.norm(force.force(0.0, x, v)[:, 0], axis=1)
        assert ((pull == 0) == ("slack" in name or "clamped" in name)).all(), name
        d = x[:, 1] - x[:, 0]
        lam = np.linalg.norm(d, axis=1) / L
        e = lam - 1 if reported.engineering[0] else 0.5 * (lam**2 - 1)
        if "toe" in name and "slack" not in name:
            assert ((e < EPS) == ("in the toe" in name)).all(), name


def test_a_dashpot_is_dissipated_power_by_the_formula():
    """(S − g) Ė11 Ā L̄ with the clamped S, from Eq. (3) by hand."""
    for name in ("taut dashpot", "taut dashpot clamped", "slack dashpot"):
        force, t, x, v = CASES[name]()
        d, w = x[:, 1] - x[:, 0], v[:, 1] - v[:, 0]
        LL, EA = force.parameters.L2, force.parameters.EA
        E11 = 0.5 * (np.sum(d * d, axis=1) / LL - 1)
        rate = np.sum(d * w, axis=1) / LL
        g = np.where(E11 >= 0, E11, 0.0)
        S = np.where(E11 >= 0, np.maximum(E11 + TAU * rate, 0.0), 0.0)
        assert force.account(t, x, v).dissipated_power == pytest.approx(
            np.sum((S - g) * rate * EA * np.sqrt(LL)), rel=1e-12, abs=1e-15
        )


@pytest.mark.parametrize("engineering", [False, True])
def test_the_toe_law_joins_smoothly_and_loses_half_a_toe(engineering):
    eps, tiny = 1e-3, 1e-12
    strain_of_stretch = eps + 0.5 * eps**2 if engineering else eps  # where λ − 1, or E11, is ε
    below, above = (law_of(strain_of_stretch * (1 + s), eps, engineering) for s in (-tiny, tiny))
    assert below[0] == pytest.approx(above[0], rel=1e-10)
    assert below[1] == pytest.approx(above[1], rel=1e-10)
    assert below[3] == pytest.approx(above[3], rel=1e-10)
    assert law_of(0.0, eps, engineering)[:2] == (0.0, 0.0)
    assert law_of(-1e-300, eps, engineering) == (0.0, 0.0, 0.0, 0.0)
    sharp, soft = law_of(0.01, 0.0, engineering), law_of(0.01, eps, engineering)
    stretch = np.sqrt(1.02)
    lost = 0.5 * eps / (stretch if engineering else 1.0)
    assert sharp[0] - soft[0] == pytest.approx(lost, rel=1e-12)


def test_a_vanishing_toe_is_the_sharp_law():
    E11 = np.linspace(-0.01, 0.01, 41)
    for engineering in (False, True):
        sharp = np.array([law_of(e, 0.0, engineering) for e in E11])
        toe = np.array([law_of(e, 1e-12, engineering) for e in E11])
        kink = E11 == 0.0  # there g′ is E without a toe and 0 with one
        # stress off by ε/2; g″ alone is of another size inside the toe
        np.testing.assert_allclose(toe[~kink][:, [0, 1, 3]], sharp[~kink][:, [0, 1, 3]], rtol=0, atol=1e-11)


def test_the_engineering_law_differs_in_force_by_one_and_a_half_strains():
    """N = EA (λ − 1) against N = EA λ (λ² − 1)/2 = EA e (1 + 3e/2 + e²/2)."""
    for e in (1e-4, 1e-3):
        stretch = 1 + e
        E11 = 0.5 * (stretch**2 - 1)
        linear, quadratic = (law_of(E11, 0.0, law)[0] * stretch for law in (True, False))
        assert linear == pytest.approx(e, rel=1e-11)  # e itself is rounded by 1e-16/e
        assert quadratic / linear - 1 == pytest.approx(1.5 * e + 0.5 * e**2, rel=1e-7)


def test_coincident_nodes_give_zero_and_no_nan():
    for name, make in CASES.items():
        force, t, x, v = make()
        if force.law is CABLE:
            packed = np.broadcast_to(x[:, :1], x.shape).copy()
            with np.errstate(all="raise"):
                assert not force.force(t, packed, v).any(), name
                K, C = force.tangent(t, packed, v).spread(len(x))
            assert not K.any(), name
            assert not C.any(), name
            assert force.account(t, packed, v) == (0.0, 0.0, 0.0)


def test_a_dashpot_by_zeta_is_that_share_of_critical():
    """Two lumps m/2 on a spring k: reduced mass m/4, critical 2√(k m/4) = √(k m); c = ζ√(k m) = τ k."""
    from conftest import CORD, line

    from netdae.model.material import Cords

    net = line(1, length=0.7)
    tau = Dashpot(zeta=0.1).viscosity_times(net, Cords.of(net, CORD))
    area = np.pi / 4 * 1e-6
    m, k = 1390.0 * area * 0.7, 70e9 * area / 0.7
    assert tau[0] * k == pytest.approx(0.1 * np.sqrt(k * m), rel=1e-12)
