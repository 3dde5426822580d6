"""The section [target] of a scenario with its parts, and the rigid body that it makes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.model.presets import PresetName, preset_of
from netdae.model.shapes.part import Part
from netdae.model.shapes.rigid_body import RigidBody
from netdae.model.target import Contact, Target, TargetMotion
from netdae.scenario.initial import Deviation
from netdae.scenario.problems import InSection
from netdae.scenario.section import Section, Vector
from netdae.scenario.shapes import (
    ContactFriction,
    ContactKeys,
    Dissipation,
    ShapeKeys,
    SlipSpeed,
    Stiffness,
    contact_of,
    part_of,
    shape_of,
    turned,
)


def _check_inertia(value: Any) -> Any:
    rows = value if isinstance(value, list) and len(value) == 3 else []
    numbers = [each for row in rows for each in (row if isinstance(row, list) else [row])]
    if len(numbers) not in (3, 9) or not all(
        isinstance(each, int | float) and not isinstance(each, bool) for each in numbers
    ):
        raise PydanticCustomError("inertia", "three principal moments, or three rows of three numbers")
    return value


BodyMass = Annotated[float, Field(gt=0, le=1e12)]  # kg
BodyDensity = Annotated[float, Field(gt=0, le=1e6)]  # kg/m³
Moment = Annotated[float, Field(ge=-1e18, le=1e18)]  # kg m²
Inertia = Annotated[list[Moment | list[Moment]], BeforeValidator(_check_inertia)]


class PartEntry(ShapeKeys):
    """A part of a target; its contact is that of the target where nothing else is given."""

    position: Vector = Field((0.0, 0.0, 0.0), description="Place of its origin in the target, m.")
    attitude_deg: Vector = Field(
        (0.0, 0.0, 0.0), description="Turns about the target's x, then y, then z axis, degrees."
    )
    mass: BodyMass | None = Field(None, description="Of the part, kg; or give that of the target.")
    density: BodyDensity | None = Field(None, description="Of the part, kg/m³; or give its mass.")
    stiffness: Stiffness | None = Field(None, description="As of the target.")
    exponent: float | None = Field(None, description="As of the target.")
    dissipation: Dissipation | None = Field(None, description="As of the target.")
    friction: ContactFriction | None = Field(None, description="As of the target.")
    slip_speed: SlipSpeed | None = Field(None, description="As of the target.")
    closing_speed: SlipSpeed | None = Field(None, description="As of the target.")


class TargetSpread(Section):
    """Standard deviations of errors of a target that are drawn from normal distributions, for each axis."""

    position: Deviation = Field(0.0, description="Of its place, m.")
    attitude_deg: Deviation = Field(0.0, description="Of a further turn about each axis of space, degrees.")
    velocity: Deviation = Field(0.0, description="Of its velocity, m/s.")
    spin_deg_s: Deviation = Field(0.0, description="Of its spin, degrees/s.")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="Seed of the draws.")
    member: Annotated[int, Field(ge=0)] = Field(
        0, description="Member of netdae run --ensemble --scatter whose draws are taken."
    )

    @property
    def draws(self) -> bool:
        """Whether any error is drawn."""
        return max(self.position, self.attitude_deg, self.velocity, self.spin_deg_s) > 0

    def drawn(self) -> FloatArray:
        """Errors of place, attitude, velocity and spin, (4, 3); each has a stream of its own."""
        streams = np.random.default_rng((self.seed, self.member)).spawn(4)
        deviations = (self.position, self.attitude_deg, self.velocity, self.spin_deg_s)
        return np.array([k * each.standard_normal(3) for k, each in zip(deviations, streams, strict=True)])


class TargetEntry(ContactKeys, ShapeKeys):
    """A rigid body that the net meets."""

    preset: PresetName | None = Field(
        None, description="A body with published mass and size, instead of kind."
    )
    parts: list[PartEntry] | None = Field(None, description="What it is made of, instead of kind.")
    motion: TargetMotion = Field(
        "free", description='"free", "fixed", or "moving" with constant velocity and spin.'
    )
    mass: BodyMass | None = Field(None, description="Mass, kg; or give density.")
    density: BodyDensity | None = Field(None, description="Density of all parts, kg/m³.")
    inertia: Inertia | None = Field(
        None,
        description="About the centre of mass: three moments or three rows, kg m²; of the shape by default.",
    )
    centre: Vector | None = Field(
        None, description="Centre of mass in the target's frame, m, with inertia; from the shape by default."
    )
    position: Vector = Field((0.0, 0.0, 0.0), description="Place of its origin at the start, m.")
    attitude_deg: Vector = Field(
        (0.0, 0.0, 0.0), description="Turns about the fixed x, then y, then z axis at the start, degrees."
    )
    velocity: Vector = Field((0.0, 0.0, 0.0), description="Of the centre of mass at the start, m/s.")
    spin_deg_s: Vector = Field(
        (0.0, 0.0, 0.0), description="Spin about the target's own x, y and z axes at the start, degrees/s."
    )
    spread: TargetSpread | None = Field(None, description="Errors that are drawn, beside what is given.")


def target_of(entry: TargetEntry | None, folder: Path, net_size: float, section: InSection) -> Target | None:
    """The target of an entry, None where there is none; raises InputError, through `section`, for what cannot be.

    folder : of the scenario file, to which meshes are relative
    net_size : m, of the net
    """
    if entry is None:
        return None
    with section("target"):
        _check_one(entry)
    parts, contacts = _parts_of(entry, folder, net_size, section)
    errors = np.zeros((4, 3)) if entry.spread is None else entry.spread.drawn()
    with section("target"):
        return Target(
            parts,
            _body_of(entry, parts),
            entry.motion,
            entry.position + errors[0],
            turned(entry.attitude_deg, further=errors[1]),
            entry.velocity + errors[2],
            np.radians(entry.spin_deg_s + errors[3]),
            contact_of(entry),
            contacts,
        )


def _check_one(entry: TargetEntry) -> None:
    given = [name for name in ("kind", "file", "preset", "parts") if getattr(entry, name) is not None]
    if len(given) != 1:
        found = " and ".join(given) + " are given" if given else "it has no shape"
        raise InputError(f"{found}: give just one of kind, file, preset and [[target.parts]]")
    if entry.parts == []:
        raise InputError("it has no parts: give [[target.parts]] with one shape at least, or kind")
    keys = [name for name in ShapeKeys.model_fields if name not in ("kind", "file")]
    sizes = [name for name in keys if getattr(entry, name) is not None]
    if given[0] in ("preset", "parts") and sizes:
        raise InputError(f"{sizes[0]} is given beside {given[0]}, which has sizes of its own: leave it out")


def _parts_of(
    entry: TargetEntry, folder: Path, net_size: float, section: InSection
) -> tuple[tuple[Part, ...], tuple[Contact | None, ...]]:
    if entry.preset is not None:
        return preset_of(entry.preset).parts, ()
    if entry.parts is None:
        with section("target"):
            return (Part(shape_of(entry, folder, net_size)),), ()
    parts, contacts = [], []
    for number, each in enumerate(entry.parts):
        with section("target.parts", number):
            parts.append(part_of(shape_of(each, folder, net_size), each.position, each.attitude_deg))
            own = {name: getattr(each, name) for name in ContactKeys.model_fields}
            changed = {name: value for name, value in own.items() if value is not None}
            contacts.append(contact_of(entry.model_copy(update=changed)) if changed else None)
    return tuple(parts), tuple(contacts)


def _body_of(entry: TargetEntry, parts: tuple[Part, ...]) -> RigidBody | None:
    """Mass properties: given, of a preset, or of uniform parts; None for a body that needs none and has none."""
    listed = entry.parts or []
    weighed = [
        number for number, each in enumerate(listed) if each.mass is not None or each.density is not None
    ]
    if entry.mass is not None and entry.density is not None:
        raise InputError("mass and density are both given: give the one or the other")
    if weighed and (entry.mass is not None or entry.density is not None):
        raise InputError(
            f"mass or density is given for the target and for part {weighed[0] + 1} of it: give it once"
        )
    if entry.centre is not None and entry.inertia is None:
        raise InputError("centre is given without inertia: give both, or leave it to the shape")
    if entry.inertia is not None:
        if entry.mass is None:
            raise InputError("inertia is given without mass: give both")
        return RigidBody.from_inertia(entry.mass, entry.inertia, centre=entry.centre or (0.0, 0.0, 0.0))
    if entry.mass is not None:
        return RigidBody.of_parts(parts, mass=entry.mass)
    if entry.density is not None:
        return RigidBody.of_parts(parts, density=entry.density)
    if entry.preset is not None:
        return preset_of(entry.preset).body
    if not weighed:
        return None
    if len(weighed) < len(listed):
        lacking = next(number for number in range(len(listed)) if number not in weighed)
        raise InputError(
            f"part {lacking + 1} has no mass, but part {weighed[0] + 1} has: give each one, or none"
        )
    for number, each in enumerate(listed):
        if each.mass is not None and each.density is not None:
            raise InputError(f"part {number + 1} has mass and density: give the one or the other")
    volumes = [part.solid().mass for part in parts]
    masses = [
        each.mass if each.mass is not None else (each.density or 0.0) * volume
        for each, volume in zip(listed, volumes, strict=True)
    ]
    return RigidBody.of_parts(parts, masses=masses)
