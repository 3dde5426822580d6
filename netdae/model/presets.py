"""Targets with published masses and sizes.

Each is a body in its own frame, whose origin is said below, with the source of each figure.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple, get_args

from netdae.core.errors import InputError
from netdae.model.shapes.part import Part
from netdae.model.shapes.rigid_body import RigidBody
from netdae.model.shapes.solids import Box, Cone, Cylinder

PresetName = Literal["cubesat_2u", "zenit_stage", "envisat"]

_ALONG_X = (0.5**0.5, 0.0, 0.5**0.5, 0.0)  # turns a part's z axis to x


class Preset(NamedTuple):
    """Parts and mass properties of a body."""

    parts: tuple[Part, ...]
    body: RigidBody


def preset_of(name: str) -> Preset:
    """The body of that name, see `PRESETS`; raises InputError for an unknown one."""
    if name not in PRESETS:
        raise InputError(f"target: there is no preset {name!r}: choose one of {', '.join(PRESETS)}")
    return PRESETS[name]()


def cubesat_2u() -> Preset:
    """A CubeSat of two units, long along z; the origin is its middle.

    100 x 100 x 227 mm and at most 2.66 kg, by the CubeSat Design Specification of Cal Poly; uniform. RemoveDEBRIS
    caught one with a net of 5 m (Aglietti et al., 2020, doi 10.1017/aer.2019.136).
    """
    parts = (Part(Box((0.1, 0.1, 0.227), rounding=2e-3)),)  # type: ignore[arg-type]  # an array in Box
    return Preset(parts, RigidBody.of_parts(parts, mass=2.66))


def zenit_stage() -> Preset:
    """A spent second stage of the Zenit class (SL-16), along z; the origin is the middle of its tanks.

    9000 kg, 11 m long and 3.9 m across: the class that leads the most concerning derelicts of McKnight et al. (2021,
    Acta Astronautica 181, 282, doi 10.1016/j.actaastro.2021.01.021). That 1.5 m of the length are a nozzle, closed
    here, and that the body is uniform, is assumed.
    """
    parts = (
        Part(Cylinder(1.95, 9.5, rounding=0.02)),
        Part(Cone(0.95, 0.35, 1.5, rounding=0.02), position=(0.0, 0.0, -5.5)),  # type: ignore[arg-type]
    )
    return Preset(parts, RigidBody.of_parts(parts, mass=9000.0))


def envisat() -> Preset:
    """A body with one solar panel like Envisat, long along x; the origin is its centre of mass.

    Mass 7827.867 kg and inertia after the end of its mission, as in the attitude studies of the D-SPOSE propagator
    (Sagnières, Sharf and Deleflie, 2018, Advances in Space Research 61, 2711). Sizes by ESA (Envisat, space segment): a
    launched length of 10.5 m, which is that of the body here, 26 m in orbit, with a panel of 14 m x 5 m. The body is
    taken 2.75 m wide and high, and 0.1 m is the thickness of the panel. The centre of mass is 3.86 m from the end that
    carries the panel (ILRS, Envisat centre-of-mass information). Antennas are left out.
    """
    base = 3.86
    parts = (
        Part(Box((10.5, 2.75, 2.75), rounding=0.02), position=(base - 5.25, 0.0, 0.0)),  # type: ignore[arg-type]
        Part(Cylinder(0.1, 1.7, rounding=0.02), (base + 0.75, 0.0, 0.0), _ALONG_X),  # type: ignore[arg-type]
        Part(Box((14.0, 5.0, 0.1), rounding=0.02), position=(base + 1.5 + 7.0, 0.0, 0.0)),  # type: ignore[arg-type]
    )
    tensor = [[17023.3, 397.1, -2171.4], [397.1, 124825.7, 344.2], [-2171.4, 344.2, 129112.2]]
    return Preset(parts, RigidBody.from_inertia(7827.867, tensor))


PRESETS: dict[str, Callable[[], Preset]] = {
    "cubesat_2u": cubesat_2u,
    "zenit_stage": zenit_stage,
    "envisat": envisat,
}
assert get_args(PresetName) == tuple(PRESETS)
