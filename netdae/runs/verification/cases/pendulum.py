"""Problem A01 of the multibody benchmark collection: 1 kg on a massless bar of 1 m, from the horizontal.

With θ from the vertical, sin(θ/2) = k sn(K(k) − √(g/l) t; k), k = sin(θ₀/2), by Jacobi's elliptic function. The pull
of the bar is m g (3 cos θ − 2 cos θ₀). netdae's bar is a cable that stretches by m g/EA: EA 1e7 N, 3e-6 at most.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipk

from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.runs.verification.nets import G, line
from netdae.solvers.flight import simulate
from netdae.system.damping import NoDamping
from netdae.system.system import System

EA, MASS, END = 1e7, 1.0, 10.0  # N, kg, s


def place_of(t: np.ndarray) -> np.ndarray:
    """x and y of the mass at times t, (2, k), m, from rest at (1, 0)."""
    m = 0.5  # k² = sin²(π/4)
    sn, _, dn, _ = ellipj(ellipk(m) - np.sqrt(G) * t, m)
    half_sine, half_cosine = np.sqrt(m) * sn, dn
    return np.stack((2 * half_sine * half_cosine, half_sine**2 - half_cosine**2))


def fly(setting: Setting) -> Study:
    """Ten seconds, five swings."""
    cord = Material(youngs_modulus=1e6 * EA, area=1e-6, linear_density=1e-9)
    gravity, anchor = Gravity([0.0, -G, 0.0]), Restraint("first")
    system = System(
        line(1),
        cord,
        damping=NoDamping(),
        masses={"last": MASS},
        loads=[gravity],
        restraints=[anchor],
    )
    times = np.linspace(0.0, END, 201)
    flight = simulate(system, State.at(system.net.nodes), times, options=setting.options())
    x, y = flight.positions[:, 1, :2].T
    reference = place_of(times)
    pull = np.array([system.tension(each)[0] for each in flight.positions])
    expected = -3 * MASS * G * reference[1]
    # at standard 1 % of the energy may be off, and half of that in the period
    within = 1e-3 if setting.rtol else {"standard": 5e-2, "accurate": 2e-2}.get(setting.accuracy, 0.1)
    reason = "1e-3 m is the high precision of the collection; the presets promise a share of the energy, 0.5 and 1 %"
    return Study(
        (
            Check.of("x of the mass", "m", x, reference[0], within=within, reason=reason),
            Check.of("y of the mass", "m", y, reference[1], within=within, reason=reason),
            Check.of(
                "pull of the bar",
                "N",
                pull,
                expected,
                within=3 * MASS * G * max(within, 1e-2),
                reason="its share of the largest pull, and 1 % that the presets promise for taut undamped cables",
            ),
        ),
        Picture(
            "time, s",
            "position, m",
            (Curve("x, elliptic function", times, reference[0]), Curve("y", times, reference[1])),
            (Curve("x, netdae", times[::3], x[::3]), Curve("y", times[::3], y[::3])),
        ),
    )


CASE = Case(
    name="pendulum",
    title="Pendulum of the multibody benchmark collection (A01)",
    statement="A mass let go from the horizontal swings as Jacobi's elliptic function says, for ten seconds.",
    sources=(
        Source(
            "IFToMM library of computational benchmark problems, A01 Simple pendulum",
            "http://lim.ii.udc.es/mbsbenchmark/dist/A01/A01_specification.xml",
        ),
        Source(
            "M. González, D. Dopico, U. Lugrís, J. Cuadrado, A benchmarking system for MBS simulation software: "
            "problem standardization and performance measurement, Multibody System Dynamics 16 (2006) 179–190"
        ),
    ),
    fly=fly,
    settings=(Setting("ida", rtol=1e-8), Setting("ida"), Setting("explicit")),
    quick=(Setting("ida", rtol=1e-8), Setting("explicit")),
)
