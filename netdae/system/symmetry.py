"""Whether a flight is exactly symmetric: its start, and all that acts on it.

Symbols: c centre of mass, x, v positions and velocities, f forces, (n, 3); Q an orthogonal matrix, a turn about c or a
mirror; π the permutation of nodes with c + Q (xᵢ − c) = x_π(i).

By uniqueness a flight keeps each symmetry of its start that forces and restraints have: Q vᵢ = v_π(i), and

    f_π(i)(g x, g v) = Q fᵢ(x, v)   at every state, with (g x)_π(i) = c + Q (xᵢ − c) and (g v)_π(i) = Q vᵢ,

which is tried at states that are drawn at random. No real start is so symmetric, and where folds and snaps are decided
by chance a symmetric flight may lie outside of all others. Q is found from two nodes of the smallest sets of nodes with
the same distance from c and the same mass: it takes each of both to a node of its own set.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.random import default_rng
from scipy.spatial import KDTree

from netdae.core.arrays import FloatArray, IntArray
from netdae.model.state import State
from netdae.system.system import System

EXACT = 1e-12
"""Share of the net's size within which places agree: their round-off. Disturbances are larger."""

AGREE = 1e-9
"""Share of the largest force within which forces agree: round-off of differences of places over strains of 1e-4."""

MOST_TRIED = 400
"""Candidates for Q that are looked at: nets whose nodes are nowhere special have no symmetry to be found."""


def symmetry_of(system: System, start: State, end: float) -> str | None:
    """In words, the symmetry that a flight from `start` to `end`, s, keeps exactly; None where there is none found.

    Chains and trees of cables are not looked at: nothing in them folds in one of several ways.
    """
    space = np.flatnonzero(system.in_space)
    if system.net.cable_count < len(space):
        return None
    x, v, mass = start.x[space], start.v[space], system.mass[space]
    if not mass.max(initial=0.0) > 0:
        return None
    centre = mass @ x / mass.sum()
    X = x - centre
    size = float(np.linalg.norm(X, axis=1).max())
    if size == 0.0:
        return None
    speed = float(np.linalg.norm(v, axis=1).max())
    tree = KDTree(X)
    for Q in _candidates(X, mass, size):
        away, image = tree.query(X @ Q.T)
        if away.max() > EXACT * size or len(np.unique(image)) < len(image):
            continue
        if not np.allclose(mass[image], mass, rtol=EXACT, atol=0.0):
            continue
        if np.abs(v @ Q.T - v[image]).max() > 1e-12 * speed:
            continue
        if _same_restraints(system, space, Q, image, (start.t, end)) and _same_forces(
            system, start, space, centre, Q, image, (start.t, 0.5 * (start.t + end), end)
        ):
            return _in_words(Q)
    return None


def _candidates(X: FloatArray, mass: FloatArray, size: float) -> Iterator[FloatArray]:
    """Matrices Q, without I, that take two nodes to such of their sets."""
    digits = np.round(np.stack((np.linalg.norm(X, axis=1) / size, mass / mass.max()), axis=1), 9)
    _, which, count = np.unique(digits, axis=0, return_inverse=True, return_counts=True)
    which = which.ravel()
    sets = [np.flatnonzero(which == k) for k in np.argsort(count, kind="stable")]
    sets = [each for each in sets if np.linalg.norm(X[each[0]]) > 1e-6 * size]
    if not sets:
        return
    first = sets[0]
    a = X[first[0]]
    for second in sets:
        off_line = np.linalg.norm(np.cross(X[second], a), axis=1) > 1e-6 * size * np.linalg.norm(a)
        if off_line.any():
            b = X[second[int(off_line.argmax())]]
            break
    else:
        return
    own, tried = _frame(a, b), 0
    for to_a in X[first]:
        for to_b in X[second]:
            if abs(a @ b - to_a @ to_b) > 1e-9 * size * size:
                continue
            other = _frame(to_a, to_b)
            for side in (1.0, -1.0):
                Q = other @ np.diag([1.0, 1.0, side]) @ own.T
                if np.abs(Q - np.eye(3)).max() > 1e-9:
                    tried += 1
                    yield Q
            if tried > MOST_TRIED:
                return


def _frame(a: FloatArray, b: FloatArray) -> FloatArray:
    """Orthonormal columns: along a, along b across a, and across both."""
    e1 = a / np.linalg.norm(a)
    e2 = b - (b @ e1) * e1
    e2 /= np.linalg.norm(e2)
    return np.stack((e1, e2, np.cross(e1, e2)), axis=1)


def _same_restraints(
    system: System, space: IntArray, Q: FloatArray, image: IntArray, times: tuple[float, float]
) -> bool:
    """Whether restraints hold images of nodes as they hold the nodes."""
    held: list[list[Any]] = [[] for _ in range(system.net.node_count)]
    for restraint in system.restraints:
        axes = restraint.axis_indices
        P = np.diag([1.0 if axis in axes else 0.0 for axis in range(3)])
        along = P @ np.stack([restraint.motion.at(t)[0] for t in (*times, 0.5 * sum(times))]).T
        leaves = np.zeros(3) if restraint.release_velocity is None else np.array(restraint.release_velocity)
        frees = restraint.release_velocity is not None
        for node in restraint.nodes_of(system.net):
            held[node].append(((restraint.begin, restraint.until, frees), P, along, leaves))
    for i, node in enumerate(space):
        own, other = held[node], held[space[image[i]]]
        if len(own) != len(other):
            return False
        for key, P, along, leaves in own:
            turned = (Q @ P @ Q.T, Q @ along, Q @ leaves)
            if not any(
                key == its
                and all(np.allclose(a, b, rtol=1e-9, atol=1e-12) for a, b in zip(turned, theirs, strict=True))
                for its, *theirs in other
            ):
                return False
    return True


def _same_forces(
    system: System,
    start: State,
    space: IntArray,
    centre: FloatArray,
    Q: FloatArray,
    image: IntArray,
    times: tuple[float, ...],
) -> bool:
    """Whether images of disturbed states have the images of their forces."""
    rng, length, shape = default_rng(1), float(np.median(system.net.rest_length)), (len(space), 3)
    # as it starts, where weak forces count; moving; and with taut cables, each by another strain
    states = [(0.0, start.v[space]), *((far * length, rng.standard_normal(shape)) for far in (0.1, 1.5))]
    for far, w in states:
        y = start.x[space] - centre + far * rng.standard_normal(shape)
        x, v, gx, gv = start.x.copy(), start.v.copy(), start.x.copy(), start.v.copy()
        x[space], v[space] = centre + y, w
        gx[space[image]], gv[space[image]] = centre + y @ Q.T, w @ Q.T
        for t in times:
            f, gf = system.force(t, x, v), system.force(t, gx, gv)
            scale = max(float(np.abs(f).max()), 1e-300)
            if not np.abs(gf[space[image]] - f[space] @ Q.T).max() <= AGREE * scale:
                return False
            drums = np.setdiff1d(np.arange(len(f)), space)
            if not np.abs(np.sort(gf[drums, 0]) - np.sort(f[drums, 0])).max(initial=0.0) <= AGREE * scale:
                return False
    return True


def _in_words(Q: FloatArray) -> str:
    if np.linalg.det(Q) > 0:
        angle = np.degrees(np.arccos(np.clip(0.5 * (np.trace(Q) - 1.0), -1.0, 1.0)))
        return f"a turn by {angle:.4g}° about its middle"
    values = np.linalg.eigvalsh(0.5 * (Q + Q.T))
    return "a mirror plane" if np.allclose(values, [-1.0, 1.0, 1.0], atol=1e-6) else "a turned mirror"
