"""The reference flight in Exudyn and MuJoCo, where they are installed (`pip install netdae[benchmark]`).

Both take explicit steps at a part of the stable step of the frozen Verlet, on one thread. The building of
their models is not counted.
"""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
from benchmark_flight import Clock, Flight
from benchmark_verlet import Flown

CHUNK = 200_000  # cable-steps between two looks at the clock, some 0.1 s


class NotAvailable(Exception):  # noqa: N818, no error: it is shown in the table
    """A method that this installation does not have."""


def _chunks(flight: Flight, part: float) -> tuple[float, list[int]]:
    """Step dt and the numbers of steps of all chunks of a quarter."""
    quarter = flight.end / len(flight.times)
    steps = math.ceil(quarter / (part * flight.stable_step()))
    chunk = max(1, CHUNK // flight.system.net.cable_count)
    return quarter / steps, [min(chunk, steps - done) for done in range(0, steps, chunk)]


def _directions(flight: Flight) -> np.ndarray:
    """Axis of each cable in x̄, 0 or 1: Rayleigh damping acts along it in a square net."""
    net = flight.system.net
    return np.argmax(np.abs(net.nodes[net.cables[:, 1]] - net.nodes[net.cables[:, 0]]), axis=1)


# Exudyn


def _exudyn() -> Any:
    sys.exudynFast = True  # type: ignore[attr-defined]  # its build without range checks
    try:
        import exudyn
    except ImportError:
        raise NotAvailable("exudyn is not installed") from None
    return exudyn


def _exudyn_model(exu: Any, flight: Flight) -> tuple[Any, Any, list[Any]]:
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
    net, EA, case = flight.system.net, flight.system.cords.axial_stiffness, flight.case
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
                damping=case.tau * stiffness,
                force=L,
                springForceUserFunction=law,
            )
        )
        if case.beta:
            damping = [0.0, 0.0, 0.0]
            damping[axis] = case.beta * stiffness / L
            model.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=ends, damping=damping))
    model.Assemble()
    return container, model, [law]


def fly_exudyn(flight: Flight, part: float, clock: Clock) -> Flown:
    """Exudyn's explicit velocity Verlet."""
    exu = _exudyn()
    kept = _exudyn_model(exu, flight)
    model = kept[1]
    dt, chunks = _chunks(flight, part)
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


def _mujoco_model(flight: Flight, dt: float) -> str:
    """MJCF: bodies on three slides; each cable an actuator on a tendon whose force is clamped to pull.

    A tendon's own spring can be slack, but its damper is always on; a clamped actuator k (L − l) − τ k l̇ ≤ 0
    lets go of both, but for the last moment before it is taut.
    """
    net, EA, case = flight.system.net, flight.system.cords.axial_stiffness, flight.case
    bodies = "".join(
        f'<body pos="{x:.17g} {y:.17g} {z:.17g}"><inertial pos="0 0 0" mass="{mass:.17g}" diaginertia="1 1 1"/>'
        f'{_SLIDES.format(i=i)}<site name="{i}"/></body>'
        for i, ((x, y, z), mass) in enumerate(zip(flight.x, flight.system.mass, strict=True))
    )
    tendons, actuators = [], []
    for e, ((i, j), L, axis) in enumerate(zip(net.cables, net.rest_length, _directions(flight), strict=True)):
        k = EA[e] / L
        tendons.append(f'<spatial name="{e}"><site site="{i}"/><site site="{j}"/></spatial>')
        actuators.append(f'<general tendon="{e}" biasprm="{k * L:.17g} {-k:.17g} {-case.tau * k:.17g}"/>')
        if case.beta:
            a = "xy"[axis]
            tendons.append(
                f'<fixed name="d{e}" damping="{case.beta * k:.17g}">'
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


def fly_mujoco(flight: Flight, part: float, clock: Clock) -> Flown:
    """MuJoCo's symplectic Euler step."""
    try:
        import mujoco
    except ImportError:
        raise NotAvailable("mujoco is not installed") from None
    dt, chunks = _chunks(flight, part)
    model = mujoco.MjModel.from_xml_string(_mujoco_model(flight, dt))
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
