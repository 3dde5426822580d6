"""A chain that hangs from one end swings in modes with ω = (j/2) √(g/L), j the zeros of the Bessel function J₀.

Links of L/N and half a link's mass at the end shift a mode by N⁻² and, by the mass, h/L of higher ones. Thrown in a
mode of the chain of links the swing is a cosine; its energy stays.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import jn_zeros

from netdae.core.arrays import FloatArray
from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Refinement, Setting, Source, Study
from netdae.runs.verification.nets import G
from netdae.solvers.driver import integrate
from netdae.solvers.modes import frequencies
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

EA, DENSITY, SWING = 1e4, 0.1, 0.02  # N, kg/m, m


def stretched(EA: float, L: float, T: float) -> float:
    """Length of a cable under a tension, by Eqs. (3) and (4)."""
    return brentq(lambda now: 0.5 * EA * ((now / L) ** 2 - 1) * now / L - T, L, 2 * L, xtol=1e-15)


def hung(
    n: int, EA: float = EA, linear_density: float = DENSITY, tau: float = 0.0
) -> tuple[System, FloatArray, FloatArray]:
    """A chain of 1 m in n links at rest: the system, its places (n + 1, 3) and the tensions of its links (n,)."""
    nodes = np.zeros((n + 1, 3))
    nodes[:, 2] = -np.arange(n + 1) / n
    links = np.stack((np.arange(n), np.arange(n) + 1), axis=1)
    net = CableNet(nodes, links, {"top": np.array([0])})
    system = System(
        net,
        Material(youngs_modulus=1e6 * EA, linear_density=linear_density, area=1e-6),
        damping=Dashpot(viscosity_time=tau) if tau else NoDamping(),
        loads=[Gravity([0.0, 0.0, -G])],
        restraints=[Restraint("top")],
    )
    T = G * (system.mass.sum() - np.cumsum(system.mass)[:-1])
    x = np.zeros_like(nodes)
    x[1:, 2] = -np.cumsum([stretched(EA, 1 / n, each) for each in T])
    return system, x, T


def shapes_of(system: System, x: FloatArray, T: FloatArray) -> tuple[FloatArray, FloatArray]:
    """ω (n,), rad/s, and shapes (n, modes) of sideways swings, by the chain's own matrix written out here."""
    q = T / -np.diff(x[:, 2])
    K = np.diag(np.append(q[1:], 0.0) + q) - np.diag(q[1:], 1) - np.diag(q[1:], -1)
    root = np.sqrt(system.mass[1:])
    squares, shapes = np.linalg.eigh(K / np.outer(root, root))
    return np.sqrt(squares), shapes / root[:, None]


def modes_of(setting: Setting) -> Study:
    """The first three frequencies of a chain at rest."""
    system, x, T = hung(setting.mesh)
    found, _ = frequencies(system, State.at(x), count=6)
    found = found[::2]  # each in x and in y
    bessel = 0.5 * jn_zeros(0, 3) * np.sqrt(G) / (2 * np.pi)
    lumps = shapes_of(system, x, T)[0][:3] / (2 * np.pi)
    number = np.arange(1, 4)
    return Study(
        (
            Check.of(
                "frequencies against Bessel's zeros",
                "Hz",
                found,
                bessel,
                relative=0.01 * (50 / setting.mesh) ** 2 + 5e-5,
                reason="links of 1/50 shift the third mode by less than a hundredth, and as their square; stretch 5e-5",
            ),
            Check.of(
                "frequencies of the links",
                "Hz",
                found,
                lumps,
                relative=1e-8,
                reason="the eigenvalue solver's tolerance",
            ),
        ),
        Picture(
            "number of the mode",
            "frequency, Hz",
            (Curve("Bessel's zeros", number, bessel),),
            (Curve("netdae", number, found),),
        ),
    )


def swing(setting: Setting, mode: int = 1, tau: float = 0.0) -> Study:
    """Two periods of a mode of the links, which is thrown from rest with 2 cm of amplitude."""
    system, x, T = hung(setting.mesh, tau=tau)
    omegas, shapes = shapes_of(system, x, T)
    omega, shape = omegas[mode - 1], shapes[:, mode - 1] / np.abs(shapes[:, mode - 1]).max()
    v = np.zeros_like(x)
    v[1:, 0] = SWING * omega * shape
    times = np.linspace(0.0, 4 * np.pi / omega, 41)
    peaks: list[float] = []
    states = list(
        integrate(
            system,
            State.at(x, v),
            times,
            options=setting.options(),
            watch=[lambda state: peaks.append(state.balance.peak_tension)],
        )
    )
    energies = np.array([energy(system, state) for state in states])
    kinetic = system.kinetic_energy(v)
    in_tension = {"standard": 0.02, "accurate": 0.01}.get(setting.accuracy, 0.05)
    # link by link T = Σ m (g + v²/r), with 1/r the slope of the mode: the swing's share is of second order in it
    rise = 4.0 * SWING**2 * omega**2 / G
    swung = np.array([state.x[-1, 0] for state in states]) / (SWING * shape[-1])
    return Study(
        (
            Check.of(
                f"energy kept in mode {mode}",
                "J",
                energies,
                energies[0],
                within=0.025 * kinetic,
                reason="the presets promise 2.5 % of the swing's energy",
            ),
            Check.of(
                f"peak tension in mode {mode}",
                "N",
                max(peaks),
                T.max() * (1 + 0.5 * rise),
                within=T.max() * (0.5 * rise * (1 + in_tension) + in_tension),
                reason="between the tension at rest and its rise by the swing, and the share that the preset promises",
            ),
        ),
        Picture(
            "time, s",
            "swing of the free end, of its amplitude",
            (Curve("sin ωt, small swings", times, np.sin(omega * times)),),
            (Curve(f"netdae, mode {mode}", times, swung),),
        ),
    )


def energy(system: System, state: State) -> float:
    """Kinetic and elastic energy, that in the field of gravity where a node is held, and what dashpots took, J."""
    total = system.kinetic_energy(state.v) + system.elastic_energy(state.x) + state.balance.dissipated_energy
    return float(total + (G * float(system.mass @ state.x[:, 2]) if system.restraints else 0.0))


def fly(setting: Setting) -> Study:
    """Frequencies, or flights in the first three modes."""
    if setting.method == "modes":
        return modes_of(setting)
    swings = [swing(setting, mode) for mode in (1, 2, 3)]
    return Study(tuple(check for each in swings for check in each.checks), swings[0].picture)


MESHES = (25, 50, 100, 200)
CASE = Case(
    name="hanging-chain",
    title="Modes of a hanging chain",
    statement="A hanging chain has the frequencies of Bessel's zeros; thrown in a mode it keeps tension and energy.",
    sources=(Source("D. Bernoulli, 1733; H. Lamb, Higher Mechanics, Cambridge University Press 1920, § 92"),),
    fly=fly,
    settings=(
        Setting("modes", 50),
        Setting("ida", 50, "standard"),
        Setting("ida", 50, "accurate"),
        Setting("explicit", 50, "accurate"),
    ),
    quick=(Setting("modes", 50), Setting("ida", 50, "standard"), Setting("explicit", 25, "standard")),
    refinements=(
        Refinement(
            "links",
            MESHES,
            tuple(Setting("modes", N) for N in MESHES),
            "frequencies against Bessel's zeros",
            -2.0,
            0.03,
            "the lumps' second order",
        ),
    ),
)
