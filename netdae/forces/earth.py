"""The Earth as seen from a circular orbit: gravity, upper atmosphere, sunlight, magnetic field.

Symbols: h altitude above the equatorial radius, a = R + h radius of the orbit, n mean motion, V circular speed.

    n = √(μ/a³),   V = √(μ/a) = n a                                   Kepler's third law
    ρ(h) = ρₖ exp(−(h − hₖ)/Hₖ)   for hₖ ≤ h < hₖ₊₁                   air in layers
    B(h) = B₀ (a_B/a)³                                                dipole over its equator; twice over a pole
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.core.errors import InputError

GRAVITATION = 3.986004418e14
"""μ of the Earth, m³/s² (IERS Conventions 2010, Petit and Luzum, IERS Technical Note 36, table 1.1)."""

RADIUS = 6378137.0
"""Equatorial radius, m (World Geodetic System 1984, NIMA TR8350.2, table 3.1)."""

J2 = 1.0826359e-3
"""Dynamical form factor, the oblateness (IERS Conventions 2010, table 1.1)."""

LIGHT_SPEED = 299792458.0
"""Speed of light, m/s (exact by the definition of the metre)."""

SOLAR_IRRADIANCE = 1360.8
"""Total solar irradiance at 1 AU, W/m² (Kopp and Lean 2011, Geophys. Res. Lett. 38, L01706)."""

SOLAR_PRESSURE = SOLAR_IRRADIANCE / LIGHT_SPEED
"""Pressure of sunlight at 1 AU on a body that absorbs it all, 4.54e-6 Pa; on a mirror it is twice that."""

DIPOLE_FIELD, DIPOLE_RADIUS = 2.98059e-5, 6371.2e3
"""B₀ in T at a_B in m over the magnetic equator: the length of the vector (g₁⁰, g₁¹, h₁¹) = (−29404.8, −1450.9,
4652.5) nT of the year 2020 (IGRF-13, Alken et al. 2021, Earth Planets Space 73, 49, table 2)."""

LOWEST_ALTITUDE = 120e3
"""Altitude in m below which no orbit lasts one revolution and the air is not a free molecular stream."""

# hₖ km, ρₖ kg/m³, Hₖ km: Vallado 2013, Fundamentals of Astrodynamics and Applications, 4th ed., table 8-4, from
# CIRA-72, from 500 km on with an exosphere of 1000 K: a mean Sun. Its activity changes the true density at 600 km by
# more than a power of ten (Vallado 2013, section 8.6.2).
_LAYERS = (
    (120, 2.438e-8, 9.473),
    (130, 8.484e-9, 12.636),
    (140, 3.845e-9, 16.149),
    (150, 2.070e-9, 22.523),
    (180, 5.464e-10, 29.740),
    (200, 2.789e-10, 37.105),
    (250, 7.248e-11, 45.546),
    (300, 2.418e-11, 53.628),
    (350, 9.518e-12, 53.298),
    (400, 3.725e-12, 58.515),
    (450, 1.585e-12, 60.828),
    (500, 6.967e-13, 63.822),
    (600, 1.454e-13, 71.835),
    (700, 3.614e-14, 88.667),
    (800, 1.170e-14, 124.64),
    (900, 5.245e-15, 181.05),
    (1000, 3.019e-15, 268.00),
)
_BASES = tuple(1e3 * layer[0] for layer in _LAYERS)


def radius_of(altitude: float) -> float:
    """Radius a of the circular orbit at an altitude in m, m; raises InputError below `LOWEST_ALTITUDE`."""
    if not (math.isfinite(altitude) and altitude >= LOWEST_ALTITUDE):
        raise InputError(
            f"altitude is {altitude:g} m: no orbit lasts under {LOWEST_ALTITUDE:g} m; give the altitude above the "
            "equatorial radius in metres, for instance 600e3"
        )
    return RADIUS + altitude


def mean_motion(altitude: float) -> float:
    """Mean motion n of the circular orbit at an altitude in m, rad/s; raises InputError as `radius_of` does."""
    return math.sqrt(GRAVITATION / radius_of(altitude) ** 3)


def circular_speed(altitude: float) -> float:
    """Speed V on the circular orbit at an altitude in m, m/s; raises InputError as `radius_of` does."""
    return math.sqrt(GRAVITATION / radius_of(altitude))


def altitude_of(mean_motion: float) -> float:
    """Altitude in m of the circular orbit with a mean motion in rad/s.

    Raises InputError where there is no orbit: a mean motion of zero or less, or one below `LOWEST_ALTITUDE`.
    """
    fastest = math.sqrt(GRAVITATION / (RADIUS + LOWEST_ALTITUDE) ** 3)
    if not 0 < mean_motion < math.inf:
        raise InputError(
            f"mean_motion is {mean_motion:g} rad/s: give one above zero, at most {fastest:.6g} rad/s"
        )
    altitude = (GRAVITATION / mean_motion**2) ** (1 / 3) - RADIUS
    if altitude < LOWEST_ALTITUDE * (1 - 1e-12):  # round-off of the conversion there and back
        raise InputError(
            f"mean_motion is {mean_motion:g} rad/s, an orbit at the altitude {altitude:.6g} m: none lasts under "
            f"{LOWEST_ALTITUDE:g} m; give {fastest:.6g} rad/s at most"
        )
    return max(altitude, LOWEST_ALTITUDE)


def magnetic_field(altitude: float) -> float:
    """Flux density in T of the Earth's dipole over the magnetic equator; raises InputError as `radius_of` does."""
    return DIPOLE_FIELD * (DIPOLE_RADIUS / radius_of(altitude)) ** 3


@dataclass(frozen=True, eq=False)
class DensityTable:
    """Density of the air over altitude, given by the user; exponential between two rows.

    altitude : (k,), m, rising; density : (k,), kg/m³, above zero

    Raises InputError that names the row.
    """

    altitude: FloatArray
    density: FloatArray

    def __init__(self, altitude: ArrayLike, density: ArrayLike) -> None:
        h, rho = frozen_floats(altitude), frozen_floats(density)
        if h.ndim != 1 or h.shape != rho.shape or len(h) < 2:
            raise InputError(
                f"the density table has the shapes {h.shape} and {rho.shape}: give as many altitudes as densities, "
                "two rows at least"
            )
        wrong = np.flatnonzero(~(np.isfinite(rho) & (rho > 0)))
        if len(wrong):
            raise InputError(
                f"row {wrong[0] + 1} of the density table has the density {rho[wrong[0]]:g} kg/m³: give one above zero"
            )
        if not np.isfinite(h).all() or not (np.diff(h) > 0).all():
            falls = int(np.argmin(np.diff(h) > 0)) + 1
            raise InputError(
                f"row {falls + 1} of the density table has the altitude {h[falls]:g} m after {h[falls - 1]:g} m: "
                "give rising altitudes in m"
            )
        object.__setattr__(self, "altitude", h)
        object.__setattr__(self, "density", rho)

    def at(self, altitude: float) -> float:
        """Density in kg/m³ at an altitude in m; raises InputError outside of the table."""
        if not self.altitude[0] <= altitude <= self.altitude[-1]:
            raise InputError(
                f"altitude is {altitude:g} m, but the density table goes from {self.altitude[0]:g} to "
                f"{self.altitude[-1]:g} m: give rows around it"
            )
        return float(np.exp(np.interp(altitude, self.altitude, np.log(self.density))))


def density(altitude: float) -> float:
    """Density of the air in kg/m³ at an altitude in m, by the layers of the module.

    The layers hold from 120 to 1000 km. Below: InputError. Above, the last layer is extended, as in the source:
    too thin, since the hydrogen up there falls off more slowly, but its effect is far below that of sunlight.
    """
    radius_of(altitude)  # raises where there is no orbit
    base, nominal, scale = _LAYERS[bisect_right(_BASES, altitude) - 1]
    return nominal * math.exp(-(altitude / 1e3 - base) / scale)
