"""A net in Exudyn and in MuJoCo: their models, and flights by explicit steps on one thread.

Neither is needed by netdae; where one is not installed its flight raises `NotAvailable`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.system.system import System

CHUNK = 200_000  # cable-steps between two looks at the clock, some 0.1 s

Flown = tuple[list[FloatArray], list[FloatArray], dict[str, int]]
"""Positions and velocities (n, 3) at each time, and counts."""


class NotAvailable(Exception):  # noqa: N818, no error: it is shown in a table
    """A method that this installation does not have."""


def _absent(name: str, error: ImportError) -> NotAvailable:
    if error.name == name:
        return NotAvailable(f"{name} is not installed")
    return NotAvailable(f"{name} cannot be imported, {str(error).splitlines()[0]}")


class Watch(Protocol):
    """Takes the time of a flight, and may end it by raising from `check`."""

    def start(self) -> None:
        """The model is built."""

    def check(self, t: float) -> None:
        """The flight has come to t."""

    def stop(self) -> None:
        """The flight has ended."""


@dataclass(frozen=True, eq=False)
class PeerFlight:
    """A free square net with a dashpot of `tau` s or, along the axes of its mesh, Rayleigh damping of `beta` s.

    x, v : (n, 3), the start
    times : equally spaced, s, at which it is measured, beginning with the first interval's end
    longest : step, s
    """

    system: System
    x: FloatArray
    v: FloatArray
    times: tuple[float, ...]
    longest: float
    tau: float = 0.0
    beta: float = 0.0

    @property
    def steps(self) -> int:
        """Number of steps of an interval."""
        return math.ceil(self.times[0] / self.longest)

    @property
    def step(self) -> float:
        """Step, s."""
        return self.times[0] / self.steps

    @property
    def chunks(self) -> list[int]:
        """Numbers of steps of all chunks of an interval."""
        chunk = max(1, CHUNK // self.system.net.cable_count)
        return [min(chunk, self.steps - done) for done in range(0, self.steps, chunk)]


def _directions(flight: PeerFlight) -> IntArray:
    """Axis of each cable in x̄, 0 or 1: Rayleigh damping acts along it in a square net."""
    net = flight.system.net
    return np.argmax(np.abs(net.nodes[net.cables[:, 1]] - net.nodes[net.cables[:, 0]]), axis=1)


# Exudyn


def _exudyn() -> Any:
    sys.exudynFast = True  # type: ignore[attr-defined]  # its build without range checks
    try:
        import exudyn
    except ImportError as error:
        raise _absent("exudyn", error) from None
    return exudyn


def _exudyn_model(exu: Any, flight: PeerFlight) -> tuple[Any, Any, list[Any]]:
    """Mass points and springs that only pull; the container and the law must live as long as the model."""
    from exudyn.advancedUtilities import CreateSymbolicUserFunction
    from exudyn.itemInterface import (
        MarkerNodePosition,
        MassPoint,
        NodePoint,
        ObjectConnectorCartesianSpringDamper,
        ObjectConnectorSpringDamper,
    )

    container = exu.SystemContainer()
    model, symbolic = container.AddSystem(), exu.symbolic
    net, EA = flight.system.net, flight.system.cords.axial_stiffness
    zero, half = symbolic.Real(0.0), symbolic.Real(0.5)

    def pull(mbs, t, itemNumber, deltaL, deltaL_t, stiffness, damping, force):  # type: ignore[no-untyped-def]
        # `force` carries the rest length L; the stress is E11 + τ Ė11, not below zero, the pull its l/L part
        length = deltaL + force
        strain = half * deltaL * (length + force) / (force * force)
        stress = stiffness * strain + damping * length * deltaL_t / (force * force)
        return symbolic.IfThenElse(deltaL > zero, symbolic.max(stress, zero) * length / force, zero)

    law = CreateSymbolicUserFunction(
        model, pull, "springForceUserFunction", itemTypeName="ObjectConnectorSpringDamper"
    )
    markers = []
    for x, v, mass in zip(flight.x.tolist(), flight.v.tolist(), flight.system.mass.tolist(), strict=True):
        node = model.AddNode(NodePoint(referenceCoordinates=x, initialVelocities=v))
        model.AddObject(MassPoint(mass=mass, nodeNumber=node))
        markers.append(model.AddMarker(MarkerNodePosition(nodeNumber=node)))
    for (i, j), L, stiffness, axis in zip(
        net.cables.tolist(), net.rest_length.tolist(), EA.tolist(), _directions(flight), strict=True
    ):
        ends = [markers[i], markers[j]]
        model.AddObject(
            ObjectConnectorSpringDamper(
                markerNumbers=ends,
                referenceLength=L,
                stiffness=stiffness,
                damping=flight.tau * stiffness,
                force=L,
                springForceUserFunction=law,
            )
        )
        if flight.beta:
            damping = [0.0, 0.0, 0.0]
            damping[axis] = flight.beta * stiffness / L
            model.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=ends, damping=damping))
    model.Assemble()
    return container, model, [law]


def fly_exudyn(flight: PeerFlight, clock: Watch) -> Flown:
    """Exudyn's explicit velocity Verlet."""
    exu = _exudyn()
    kept = _exudyn_model(exu, flight)
    model = kept[1]
    dt, chunks = flight.step, flight.chunks
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.explicit.computeEndOfStepAccelerations = False
    settings.timeIntegration.explicit.computeMassMatrixInversePerBody = True
    settings.parallel.numberOfThreads = 1
    data = model.systemData
    now, start = exu.ConfigurationType.Current, exu.ConfigurationType.Initial
    positions, velocities, t = [], [], 0.0
    clock.start()
    for _ in flight.times:
        for count in chunks:
            settings.timeIntegration.startTime = t
            settings.timeIntegration.endTime = t = t + count * dt
            settings.timeIntegration.numberOfSteps = count
            if not model.SolveDynamic(settings, solverType=exu.DynamicSolverType.VelocityVerlet):
                raise RuntimeError("Exudyn's solver failed")
            u, w = data.GetODE2Coordinates(now), data.GetODE2Coordinates_t(now)
            data.SetODE2Coordinates(u, start)
            data.SetODE2Coordinates_t(w, start)
            clock.check(t)
        positions.append(flight.x + u.reshape(-1, 3))
        velocities.append(w.reshape(-1, 3).copy())
    clock.stop()
    return positions, velocities, {"steps": len(flight.times) * sum(chunks)}


# MuJoCo

_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
_SLIDES = "".join(f'<joint name="{{i}}{a}" type="slide" axis="{axis}"/>' for a, axis in _AXES.items())


def mujoco_model(flight: PeerFlight, dt: float) -> str:
    """MJCF: bodies on three slides; each cable an actuator on a tendon whose force is clamped to pull.

    A tendon's own spring can be slack, but its damper is always on; a clamped actuator k (L − l) − τ k l̇ ≤ 0
    lets go of both, but for the last moment before it is taut.
    """
    net, EA = flight.system.net, flight.system.cords.axial_stiffness
    bodies = "".join(
        f'<body pos="{x:.17g} {y:.17g} {z:.17g}"><inertial pos="0 0 0" mass="{mass:.17g}" diaginertia="1 1 1"/>'
        f'{_SLIDES.format(i=i)}<site name="{i}"/></body>'
        for i, ((x, y, z), mass) in enumerate(zip(flight.x, flight.system.mass, strict=True))
    )
    tendons, actuators = [], []
    for e, ((i, j), L, axis) in enumerate(zip(net.cables, net.rest_length, _directions(flight), strict=True)):
        k = EA[e] / L
        tendons.append(f'<spatial name="{e}"><site site="{i}"/><site site="{j}"/></spatial>')
        actuators.append(f'<general tendon="{e}" biasprm="{k * L:.17g} {-k:.17g} {-flight.tau * k:.17g}"/>')
        if flight.beta:
            a = "xy"[axis]
            tendons.append(
                f'<fixed name="d{e}" damping="{flight.beta * k:.17g}">'
                f'<joint joint="{j}{a}" coef="1"/><joint joint="{i}{a}" coef="-1"/></fixed>'
            )
    return (
        f'<mujoco><compiler boundmass="0"/><size memory="2G"/>'
        f'<option timestep="{dt:.17g}" gravity="0 0 0" integrator="Euler" jacobian="sparse">'
        '<flag contact="disable" constraint="disable" eulerdamp="disable"/></option>'
        '<default><general gainprm="0" biastype="affine" forcelimited="true" forcerange="-1e12 0"/></default>'
        f"<worldbody>{bodies}</worldbody><tendon>{''.join(tendons)}</tendon>"
        f"<actuator>{''.join(actuators)}</actuator></mujoco>"
    )


def fly_mujoco(flight: PeerFlight, clock: Watch) -> Flown:
    """MuJoCo's symplectic Euler step."""
    try:
        import mujoco
    except ImportError as error:
        raise _absent("mujoco", error) from None
    dt, chunks = flight.step, flight.chunks
    model = mujoco.MjModel.from_xml_string(mujoco_model(flight, dt))
    data = mujoco.MjData(model)
    data.qvel[:] = flight.v.ravel()
    mujoco.mj_forward(model, data)  # its velocities are half a step behind its positions
    data.qvel -= 0.5 * dt * data.qacc
    positions, velocities = [], []
    clock.start()
    for _ in flight.times:
        for count in chunks:
            mujoco.mj_step(model, data, nstep=count)
            clock.check(data.time)
        mujoco.mj_forward(model, data)
        positions.append(flight.x + np.array(data.qpos).reshape(-1, 3))
        velocities.append((data.qvel + 0.5 * dt * data.qacc).reshape(-1, 3))
    clock.stop()
    return positions, velocities, {"steps": len(flight.times) * sum(chunks)}
