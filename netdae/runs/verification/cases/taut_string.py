"""A string of equal lumps drawn between two points, as Lagrange found: f = N c/(π l) sin(nπ/2N), n = 1 … N − 1.

c = (l/L̄) √(S11/ρ̄) is the wave's speed on the drawn string of length l, S11 = E (λ² − 1)/2. As N grows the
frequencies come to the continuum's n c/2l with x²/6, x = nπ/2N. Plucked in its first mode it swings with it.
"""

from __future__ import annotations

import math

import numpy as np

from netdae.model.material import Material
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Refinement, Setting, Source, Study
from netdae.runs.verification.nets import line
from netdae.solvers.flight import simulate
from netdae.solvers.modes import frequencies
from netdae.solvers.options import SolverOptions
from netdae.system.damping import NoDamping
from netdae.system.system import System

E, RHO, STRETCH, LENGTH = 2e9, 1100.0, 1.01, 2.0  # Pa, kg/m³, 1, m
DRAWN = STRETCH * LENGTH
SPEED = STRETCH * math.sqrt(E * 0.5 * (STRETCH**2 - 1) / RHO)  # m/s
SMALL = 1e-5  # m; so small that the pull does not change: slopes of 2e-5 raise the strain of 1e-2 by 1e-10


def string(cables: int) -> System:
    """The string along x."""
    cord = Material(youngs_modulus=E, density=RHO, diameter=2e-3)
    ends = [Restraint("first"), Restraint("last")]
    return System(line(cables, length=LENGTH), cord, damping=NoDamping(), restraints=ends)


def modes_of(setting: Setting) -> Study:
    """All transverse frequencies, each twice, in y and in z; the shape of the first."""
    N = setting.mesh
    system = string(N)
    n = np.arange(1, N)
    expected = N * SPEED / (math.pi * DRAWN) * np.sin(n * math.pi / (2 * N))
    # the longitudinal ones are ten times as high
    found, modes = frequencies(system, system.net.nodes * [STRETCH, 1.0, 1.0], count=2 * len(n))
    shape = np.sin(math.pi * np.arange(N + 1) / N)
    first = np.linalg.norm(modes[0], axis=1)
    x = 3 * math.pi / (2 * N)
    third = (
        []
        if N < 4
        else [
            Check.of(
                "third frequency against the continuum",
                "Hz",
                found[5],
                3 * SPEED / (2 * DRAWN),
                relative=1.01 * x * x / 6,
                reason="lumps lower it by x²/6, x = nπ/2N",
            )
        ]
    )
    return Study(
        (
            Check.of(
                "frequencies of the lumps",
                "Hz",
                found,
                np.repeat(expected, 2),
                relative=1e-8,
                reason="the eigenvalue solver's tolerance",
            ),
            Check.of(
                "shape of the first mode",
                "1",
                first / first.max(),
                shape / shape.max(),
                within=1e-6,
                reason="the eigenvalue solver's tolerance",
            ),
            *third,
        ),
        Picture(
            "number of the mode",
            "frequency, Hz",
            (
                Curve("Lagrange", n, expected),
                Curve("continuum", n, n * SPEED / (2 * DRAWN)),
            ),
            (Curve("netdae", n, found[::2]),),
        ),
    )


def swing(setting: Setting) -> Study:
    """A period of the first mode, flown."""
    N = setting.mesh
    system = string(N)
    drawn = system.net.nodes * [STRETCH, 1.0, 1.0]
    _, modes = frequencies(system, drawn, count=1)
    shape = SMALL * modes[0] / np.abs(modes[0]).max()
    period = math.pi * DRAWN / (N * SPEED * math.sin(math.pi / (2 * N)))
    phase = np.linspace(0.0, 1.0, 17)
    flight = simulate(system, State.at(drawn + shape), period * phase, options=_options(setting))
    swung = np.einsum("tni,ni->t", flight.positions - drawn, shape) / (shape**2).sum()
    expected = np.cos(2 * math.pi * phase)
    within, reason = (
        (1e-4, "of the swing: the integrator's tolerance")
        if setting.method == "ida"
        else (
            1e-3,
            "of the swing: the phase of the explicit step, (ω h)²/24 a radian",
        )
    )
    return Study(
        (Check.of("swing in the first mode", "of its start", swung, expected, within=within, reason=reason),),
        Picture(
            "time, periods of theory",
            "swing, of its start",
            (Curve("cos 2πt/T", phase, expected),),
            (Curve("netdae", phase, swung),),
        ),
    )


def _options(setting: Setting) -> SolverOptions:
    if setting.method == "explicit":
        return setting.options()
    return SolverOptions(rtol=setting.rtol, atol_position=1e-12, atol_velocity=1e-9)


def fly(setting: Setting) -> Study:
    """Frequencies, or a flight."""
    return modes_of(setting) if setting.method == "modes" else swing(setting)


MESHES = (8, 16, 32, 64)
CASE = Case(
    name="taut-string",
    title="Taut string of lumps",
    statement="A drawn string rings and swings as Lagrange found, and comes to the continuum to second order.",
    sources=(
        Source(
            "J. L. Lagrange, Mécanique analytique, 1788; Lord Rayleigh, The Theory of Sound, vol. 1, § 120"
        ),
    ),
    fly=fly,
    settings=(
        *(Setting("modes", N) for N in (2, 5, 12)),
        Setting("ida", 6, rtol=1e-9),
        Setting("explicit", 6),
    ),
    quick=(Setting("modes", 2), Setting("modes", 12), Setting("ida", 6, rtol=1e-9), Setting("explicit", 6)),
    refinements=(
        Refinement(
            "pieces",
            MESHES,
            tuple(Setting("modes", N) for N in MESHES),
            "third frequency against the continuum",
            -2.0,
            0.03,
            "the next term, x²/20 with x = 3π/16, bends it by 0.02",
        ),
    ),
)
