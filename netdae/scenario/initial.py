"""The section [initial] of a scenario, and the start that it makes of a net."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, Strict
from pydantic_core import PydanticCustomError

from netdae.core.arrays import BoolArray, FloatArray
from netdae.core.errors import InputError
from netdae.initial import canister as stowed
from netdae.initial import ejection
from netdae.initial.accordion import MOST_FOLDS, accordion
from netdae.initial.opening import opening_finding
from netdae.initial.scaled import scaled
from netdae.initial.spin import spun
from netdae.initial.star import MOST_PLEATS, star
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.scenario.groups import check_group
from netdae.scenario.material import thickest_of
from netdae.scenario.problems import InSection
from netdae.scenario.section import Component, FactorVector, Length, Section, Speed, Text, Thickness, Vector
from netdae.system.masses import lumped_masses


def _check_two(value: Any) -> Any:
    if not (isinstance(value, list | tuple) and len(value) == 2):
        raise PydanticCustomError("two_numbers", "two numbers in brackets")
    return value


def _check_list(value: Any) -> Any:
    if not isinstance(value, list):
        raise PydanticCustomError("numbers", "numbers in brackets, one per node of the group")
    return value


FoldCount = Annotated[int, Field(ge=0, le=MOST_FOLDS)]
TwoCounts = Annotated[tuple[FoldCount, FoldCount], Strict(False), BeforeValidator(_check_two)]
TwoLengths = Annotated[tuple[Length, Length], Strict(False), BeforeValidator(_check_two)]
ReleaseTime = Annotated[float, Field(ge=0, le=1e9)]  # s
Errors = Annotated[list[Component], BeforeValidator(_check_list)]
ReleaseTimes = Annotated[list[ReleaseTime], BeforeValidator(_check_list)]
Deviation = Annotated[float, Field(ge=0, le=1e6)]  # m/s, degrees, s
Gap = Annotated[float, Field(ge=0, le=1e3)]  # m


class CanisterEntry(Section):
    """The room that the net is folded into; its floor lies in the plane of the mesh."""

    depth: Length = Field(description="Depth, along the normal of the mesh's plane, m.")
    diameter: Length | None = Field(None, description="Diameter of a round canister, m; or give side.")
    side: Length | None = Field(None, description="Side of a square canister, m.")


class SpreadEntry(Section):
    """Standard deviations of errors that are drawn from normal distributions, one per bullet."""

    speed: Deviation = Field(0.0, description="Of the speed, m/s.")
    angle_deg: Deviation = Field(0.0, description="Of the half-angle, degrees.")
    azimuth_deg: Deviation = Field(0.0, description="Of the direction about the axis, degrees.")
    time: Deviation = Field(0.0, description="Of the release, s; absolute values are taken.")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="Seed of the draws.")
    member: Annotated[int, Field(ge=0)] = Field(
        0, description="Member of netdae run --ensemble --scatter whose draws are taken."
    )


class EjectionEntry(Section):
    """Nodes that are shot outward from an axis."""

    group: Text = Field(description="Node group.")
    speed: Speed = Field(description="Speed, m/s, beside the velocity of the whole net.")
    half_angle_deg: float = Field(
        ge=0, le=180, description="Angle from the axis, outward from the middle of the group, degrees."
    )
    axis: Vector = Field((0.0, 0.0, 1.0), description="Direction in space; rotation_deg does not turn it.")
    speed_errors: Errors | None = Field(
        None, description="Added to the speed, m/s, one per bullet in the order of the group's nodes."
    )
    angle_errors_deg: Errors | None = Field(
        None, description="Added to the half-angle, degrees, one per bullet."
    )
    azimuth_errors_deg: Errors | None = Field(
        None, description="Turns about the axis, degrees, one per bullet."
    )
    release_times: ReleaseTimes | None = Field(
        None, description="Releases, s after the begin of the flight, one per bullet; held until then."
    )
    spread: SpreadEntry | None = Field(
        None, description="Errors that are drawn, beside those that are listed."
    )


class Initial(Section):
    """How the net starts: drawn together or folded, and turned."""

    shape: Literal["scaled", "accordion", "star", "equilibrium"] = Field(
        "scaled", description="How the shape at the start is made of the mesh."
    )
    scale: FactorVector = Field(
        (1.0, 1.0, 1.0), description="Of scaled and equilibrium: factors along x, y and z of the mesh."
    )
    canister: CanisterEntry | None = Field(
        None, description="Of accordion and star: the room that the net is folded into."
    )
    folds: TwoCounts | None = Field(
        None, description="Of accordion: folds along the first and second axis of the mesh's plane."
    )
    pitch: TwoLengths | None = Field(
        None, description="Of accordion: largest distance of folds along the open net, m, instead of folds."
    )
    gap: Gap | None = Field(
        None, description="Of accordion: distance of layers, m; by default what the depth leaves."
    )
    pleats: Annotated[int, Field(ge=1, le=MOST_PLEATS)] | None = Field(
        None, description="Of star: pleats from the middle of a side to a corner, odd; the fewest by default."
    )
    corners: Text = Field("corners", description="Of star: node group of the corners of the mesh.")
    cord_diameter: Thickness | None = Field(
        None, description="Of accordion and star: least room of a layer, m; by default the thickest cord."
    )
    slack: Annotated[float, Field(gt=0, lt=0.5)] = Field(
        stowed.SLACK, description="Of accordion and star: least share of its length that a cable hangs slack."
    )
    coincide: bool = Field(False, description="Of accordion: whether knots may share a place.")
    rotation_deg: Vector = Field(
        (0.0, 0.0, 0.0), description="Turns about the fixed x, then y, then z axis, degrees."
    )
    velocity: Vector = Field((0.0, 0.0, 0.0), description="Velocity of the whole net, m/s.")
    disturbance: Annotated[float, Field(ge=0, le=1e3)] = Field(
        0.0, description="Standard deviation by which each free coordinate is displaced, m."
    )
    disturbance_seed: Annotated[int, Field(ge=0)] = Field(0, description="Seed of the disturbance.")
    spin_deg_s: Vector = Field(
        (0.0, 0.0, 0.0), description="Spin about an axis through the centre of mass, degrees/s."
    )
    ejection: list[EjectionEntry] = Field([], description="Groups that are shot.")


_KEYS = {
    "scaled": ("scale",),
    "equilibrium": ("scale",),
    "accordion": ("canister", "folds", "pitch", "gap", "cord_diameter", "slack", "coincide"),
    "star": ("canister", "pleats", "corners", "cord_diameter", "slack"),
}
"""Keys that one shape has and another has not."""

SPREAD = ("scaled", "equilibrium")
"""Shapes that are not folded."""


@dataclass(frozen=True, eq=False)
class Start:
    """What [initial] makes of a net.

    net : turned as the start is
    state : positions and velocities at the begin; held bullets move with the canister
    launch : all bullets, also those that have left already
    findings : what its author should know
    """

    net: CableNet
    state: State
    launch: ejection.Launch
    findings: tuple[str, ...]


def start_of(
    initial: Initial,
    net: CableNet,
    masses: Mapping[str, float],
    section: InSection,
    *,
    cords: Cords | None = None,
    rest: FloatArray | None = None,
) -> Start:
    """Start of a net.

    masses : kg that each node of a group carries beside its cables
    cords : of the net; layers of a pack have room for the thickest where the scenario reports no diameter, and those
        with a prestress may be taut
    rest : (n, 3), m, places in which the net begins; those of the shape by default, from which shape = "equilibrium"
        is sought
    section : called with a section's name, and number, it reports errors by them

    Raises InputError, through `section`, for what cannot be folded or shot.
    """
    with section("initial"):
        _check_keys(initial)
        turned, packed = _packed(initial, net, 0.0 if cords is None else thickest_of(cords))
        findings = _findings(initial, turned, packed, None if cords is None else cords.prestress > 0)
        if rest is not None:
            packed = State.at(rest, packed.v, t=packed.t)
        added = np.zeros(turned.node_count)
        for group, mass in masses.items():
            added[turned.nodes_of(group)] += mass
        if any(initial.spin_deg_s):
            whole = added if cords is None else lumped_masses(turned, cords, masses)
            packed = spun(packed, whole, initial.spin_deg_s)
    shots: list[ejection.Ejection] = []
    state, launch = packed, ejection.Launch.none()
    for number, shot in enumerate(initial.ejection):
        with section("initial.ejection", number):
            check_group(turned.node_groups, shot.group, "node")
            shots.append(_shot_of(shot, "start" if initial.shape in SPREAD else "net"))
            ejection.check_bullets(turned, shots[-1], added)
            state, launch = ejection.fired(turned, packed, shots)
    if any(initial.spin_deg_s) and len(launch.held.nodes):
        with section("initial"):
            raise InputError(
                f"spin_deg_s is {[*initial.spin_deg_s]}, but the canister holds the bullet at node "
                f"{launch.held.nodes[0]} for {launch.held.times[0]:g} s and does not turn: "
                "leave out the times of release, or the spin"
            )
    return Start(turned, state, launch, findings)


def _check_keys(initial: Initial) -> None:
    for key in sorted(initial.model_fields_set):
        shapes = [shape for shape, keys in _KEYS.items() if key in keys]
        if shapes and initial.shape not in shapes:
            raise InputError(
                f'{key} is a key of shape = "{shapes[0]}", but shape is "{initial.shape}": '
                "leave it out, or choose another shape"
            )


def _packed(initial: Initial, net: CableNet, cord: float) -> tuple[CableNet, State]:
    turn, velocity = initial.rotation_deg, initial.velocity
    if initial.shape in SPREAD:
        turned, start = scaled(net, initial.scale, rotation_deg=turn, velocity=velocity)
        if np.ptp(start.x, axis=0).max() <= 1e-9 * np.ptp(turned.nodes, axis=0).max():
            raise InputError(
                f"scale is {[*initial.scale]}, which draws the whole net into one point: "
                "give factors that leave it a width"
            )
        return turned, start
    if initial.canister is None:
        raise InputError(
            f'canister is missing: shape = "{initial.shape}" needs its size, '
            "for instance canister = { diameter = 0.3, depth = 0.3 }"
        )
    canister = stowed.Canister(
        initial.canister.depth, diameter=initial.canister.diameter, side=initial.canister.side
    )
    thickness = cord if initial.cord_diameter is None else initial.cord_diameter
    if initial.shape == "accordion":
        return accordion(
            net,
            canister,
            folds=initial.folds,
            pitch=initial.pitch,
            gap=initial.gap,
            cord_diameter=thickness,
            slack=initial.slack,
            coincide=initial.coincide,
            rotation_deg=turn,
            velocity=velocity,
        )
    check_group(net.node_groups, initial.corners, "node")
    return star(
        net,
        canister,
        pleats=initial.pleats,
        corners=initial.corners,
        cord_diameter=thickness,
        slack=initial.slack,
        rotation_deg=turn,
        velocity=velocity,
    )


def _findings(initial: Initial, net: CableNet, start: State, tight: BoolArray | None) -> tuple[str, ...]:
    """What is worth a warning: a scaled net may be stretched on purpose, a folded one may cross itself."""
    if initial.shape == "equilibrium":
        return ()
    if initial.shape == "scaled":
        found = [stowed.taut_finding(net, start.x, tight=tight), stowed.together_finding(net, start.x)]
        if min(initial.scale) < 0:
            found.append(opening_finding(net, start))
    else:
        found = [opening_finding(net, start)]
    return tuple(f"[initial]: {finding}" for finding in found if finding)


def spread_of(spread: SpreadEntry | None) -> ejection.Spread:
    """The deviations of an ejection; none where the scenario reports none."""
    return ejection.Spread() if spread is None else ejection.Spread(**spread.model_dump())


def _shot_of(shot: EjectionEntry, outward: Literal["start", "net"]) -> ejection.Ejection:
    return ejection.Ejection(
        shot.group,
        shot.speed,
        shot.half_angle_deg,
        shot.axis,
        shot.speed_errors,
        shot.angle_errors_deg,
        shot.azimuth_errors_deg,
        shot.release_times,
        spread_of(shot.spread),
        outward,
    )
