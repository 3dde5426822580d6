"""The Earth's figures against what others have published or measured."""

import math
import subprocess
import sys

import numpy as np
import pytest

from netdae.core.errors import InputError
from netdae.forces import earth

DAY = 86400.0

# total density in kg/m³, U.S. Standard Atmosphere 1976, table I
STANDARD_1976 = {
    150e3: 2.076e-9,
    200e3: 2.541e-10,
    300e3: 1.916e-11,
    400e3: 2.803e-12,
    500e3: 5.215e-13,
    600e3: 1.137e-13,
    700e3: 3.070e-14,
    800e3: 1.136e-14,
    1000e3: 3.561e-15,
}


def test_geostationary_orbit_stands_at_35786_km():
    # one revolution in a sidereal day, 86164.0905 s
    assert earth.altitude_of(2 * math.pi / 86164.0905) == pytest.approx(35786e3, abs=100.0)


def test_space_station_goes_round_as_often_as_it_does():
    # its two-line elements report 15.49 to 15.51 revolutions a day at a mean altitude of 415 to 422 km; 0.2 % for J2
    assert earth.mean_motion(418e3) * DAY / (2 * math.pi) == pytest.approx(15.5, rel=2e-3)
    assert earth.circular_speed(418e3) == pytest.approx(7660.0, rel=2e-3)


def test_speed_is_mean_motion_times_radius():
    for altitude in (200e3, 600e3, 36e6):
        n = earth.mean_motion(altitude)
        assert earth.circular_speed(altitude) == pytest.approx(n * earth.radius_of(altitude), rel=1e-14)


def test_altitude_and_mean_motion_are_inverse():
    for altitude in (earth.LOWEST_ALTITUDE, 600e3, 36e6):
        assert earth.altitude_of(earth.mean_motion(altitude)) == pytest.approx(altitude, rel=1e-11)


@pytest.mark.parametrize(("altitude", "inclination"), [(600e3, 97.79), (800e3, 98.60)])
def test_oblateness_makes_orbits_sun_synchronous_where_they_are(altitude, inclination):
    # the node turns by −3/2 J₂ (R/a)² n cos i; published inclinations to 0.02°
    n, a = earth.mean_motion(altitude), earth.radius_of(altitude)
    year = 2 * math.pi / (365.2422 * DAY)
    cosine = -year / (1.5 * earth.J2 * (earth.RADIUS / a) ** 2 * n)
    assert math.degrees(math.acos(cosine)) == pytest.approx(inclination, abs=0.02)


@pytest.mark.parametrize("altitude", STANDARD_1976)
def test_density_is_near_the_standard_atmosphere(altitude):
    # two models of a mean sun, CIRA-72 and USSA76, which differ by a third from 300 to 600 km
    assert earth.density(altitude) == pytest.approx(STANDARD_1976[altitude], rel=0.40, abs=0)


def test_density_runs_on_from_layer_to_layer_and_falls():
    # a slip in one figure of the table would show: its layers meet within the rounding of its figures
    for base in earth._BASES[1:]:
        below, above = earth.density(base * (1 - 1e-12)), earth.density(base)
        assert below == pytest.approx(above, rel=2e-3, abs=0)
    falling = [earth.density(h) for h in np.linspace(120e3, 2000e3, 2000)]
    assert (np.diff(falling) < 0).all()


def test_sunlight_presses_as_published():
    # 4.56e-6 N/m² with the older 1367 W/m² (Montenbruck and Gill 2000, section 3.4)
    assert earth.SOLAR_PRESSURE == pytest.approx(4.56e-6, rel=6e-3)


def test_field_is_that_of_the_published_dipole():
    # dipole moment of 2020: 7.71e22 A m² (from IGRF-13); B = μ₀/4π · moment/a³ over its equator
    altitude = 600e3
    assert earth.magnetic_field(altitude) == pytest.approx(
        1e-7 * 7.71e22 / earth.radius_of(altitude) ** 3, rel=2e-3
    )


def test_density_table_is_exponential_between_its_rows_and_hits_them():
    table = earth.DensityTable([200e3, 400e3, 900e3], [1e-10, 1e-12, 1e-14])
    assert table.at(200e3) == pytest.approx(1e-10, rel=1e-9, abs=0)
    assert table.at(300e3) == pytest.approx(1e-11, rel=1e-9, abs=0)
    assert table.at(900e3) == pytest.approx(1e-14, rel=1e-9, abs=0)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (([200e3], [1e-10]), "two rows at least"),
        (([200e3, 300e3], [1e-10]), "as many altitudes as densities"),
        (([200e3, 300e3], [1e-10, 0.0]), "row 2 .* density 0 "),
        (([200e3, 200e3], [1e-10, 1e-11]), "row 2 .* altitude 200000 m after 200000 m"),
        (([200e3, math.nan], [1e-10, 1e-11]), "row 2 .* altitude nan m"),
    ],
)
def test_wrong_table_is_refused_with_its_row(rows, message):
    with pytest.raises(InputError, match=message):
        earth.DensityTable(*rows)


def test_table_is_not_asked_outside_of_its_rows():
    table = earth.DensityTable([200e3, 400e3], [1e-10, 1e-12])
    with pytest.raises(InputError, match="goes from 200000 to 400000 m"):
        table.at(500e3)


@pytest.mark.parametrize("altitude", [-1.0, 0.0, 119.9e3, math.nan, math.inf])
def test_altitude_without_an_orbit_is_refused(altitude):
    for ask in (earth.mean_motion, earth.circular_speed, earth.density, earth.magnetic_field):
        with pytest.raises(InputError, match="no orbit lasts under 120000 m"):
            ask(altitude)


@pytest.mark.parametrize("mean_motion", [0.0, -1e-3, 1.3e-3, math.nan, math.inf])
def test_mean_motion_without_an_orbit_is_refused(mean_motion):
    with pytest.raises(InputError, match=r"mean_motion is .* rad/s"):
        earth.altitude_of(mean_motion)


def test_earth_needs_nothing_heavy_but_numpy():
    code = (
        "import sys, netdae.forces.earth; print({'scipy', 'numba', 'sksundae', 'pyvista'} & {*sys.modules})"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "set()"
