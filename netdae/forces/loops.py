"""Loops over the elements of one law, compiled to C functions: gather, law, scatter. Written once for all laws.

Each function takes the addresses of `Elements` and of flat arrays over the net, node i at 3i. It is compiled when first
needed, and then loaded from disk as long as the source of the law is unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import cfunc, njit, types
from numba.extending import overload

from netdae.core.addresses import flags, floats, index
from netdae.core.arrays import BoolArray, Flags, FloatArray, IntArray, Reals, Wholes, Wholes2, wholes
from netdae.core.compilation import INLINED, OPTIONS
from netdae.core.records import Record, load
from netdae.forces.law import LAWS, Law, Shares


class Elements(NamedTuple):
    """The elements of a force in a net, and room for their results, for compiled code.

    active, K, C : the elements of the last tangents, and these tangents, one after another
    acted, taken, given : the elements that acted when powers were last summed, and their dissipative and external
        shares, one after another
    """

    parameters: int  # address of the law's
    nodes: Wholes2  # (m, k), 3i
    signal: Reals  # (3,), current s
    in_space: Flags  # (n,), False on drums, which have neither momentum nor place
    wide: Wholes  # (m,), elements among which those that may act are looked for
    near: Wholes  # (m,), elements that may act
    counts: Wholes  # (4,), how many are near, active, wide, and have acted
    least: Reals  # (m,), m, rest lengths below which an explicit step may be too long; or none
    active: Wholes  # (m,)
    acted: Wholes  # (m,)
    taken: Reals  # N
    given: Reals  # N
    K: Reals
    C: Reals
    left: Reals  # dyads of a force with links
    by_x: Reals
    by_v: Reals
    rank: Wholes  # (1,), their current number; for pairs whether any has a ∂f/∂w
    room: Reals  # for one element: 3k of positions, of velocities, and of each share


def elements_of(
    parameters: int,
    nodes: IntArray,
    in_space: BoolArray,
    *,
    tangents: int = 0,
    links: int = 0,
    dyads: int = 0,
    least: int = 0,
    taken: int = 0,
    given: int = 0,
) -> Record:
    """The record of some elements with nodes (m, k).

    tangents : numbers in K, and in C; links : their number, of which all or none act
    dyads : numbers in the vectors of each side; least : lower limits of the monitored lengths
    taken, given : numbers in the dissipative and external shares of all elements
    """
    m, k = nodes.shape
    return Record(
        Elements(
            parameters=parameters,
            nodes=3 * nodes,
            signal=np.zeros(3),
            in_space=in_space,
            wide=np.arange(m),
            near=np.arange(m),
            counts=np.array([m, 0, m, 0]),
            least=np.zeros(least),
            active=np.arange(max(m, links)),
            acted=np.arange(m),
            taken=np.zeros(taken),
            given=np.zeros(given),
            K=np.zeros(tangents),
            C=np.zeros(tangents),
            left=np.zeros(dyads),
            by_x=np.zeros(dyads),
            by_v=np.zeros(dyads),
            rank=wholes(1),
            room=np.zeros(15 * k),
        )
    )


STORED, DISSIPATED, EXTERNAL, FORCE, TORQUE, TENSION, STRAIN = 0, 1, 2, 3, 6, 9, 10
"""Places in sums over all elements: J, W, W, N (3,), N m (3,) about the origin, N², and a strain."""
TAKEN, GIVEN, FORMER, SUMS = 11, 12, 2, 15
"""Powers in W of the dissipative and external shares; at `FORMER` beyond them those of the evaluation before; and the
number of all sums."""
NEAR, ACTIVE, WIDE, ACTED = 0, 1, 2, 3
"""Places in the counts of `Elements`."""

_I, _A, _D = types.int32, types.int64, types.float64


# The law of given parameters, which compiled code finds by their class


def _stub(name: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    def of_law(*arguments: Any) -> Any:
        raise NotImplementedError("for compiled code")

    def member_of(p: Any) -> Any:
        return getattr(LAWS[p.instance_class], name)

    return of_law, member_of


_force, _force_of = _stub("force")
_tangent, _tangent_of = _stub("tangent")
_energy, _energy_of = _stub("energy")
_measured, _measured_of = _stub("measured")
_near, _near_of = _stub("near")
_rest, _rest_of = _stub("rest")
_linked, _linked_of = _stub("linked")
_rate, _rate_of = _stub("rate")
_between, _between_of = _stub("between")


@overload(_force, jit_options=INLINED)
def _(p, e, s, x, v, f):  # type: ignore[no-untyped-def]
    law = _force_of(p)
    return lambda p, e, s, x, v, f: law(p, e, s, x, v, f)


@overload(_tangent, jit_options=INLINED)
def _(p, e, s, x, v, K, C):  # type: ignore[no-untyped-def]
    law = _tangent_of(p)
    return lambda p, e, s, x, v, K, C: law(p, e, s, x, v, K, C)


@overload(_energy, jit_options=INLINED)
def _(p, e, x):  # type: ignore[no-untyped-def]
    law = _energy_of(p)
    return (lambda p, e, x: 0.0) if law is None else (lambda p, e, x: law(p, e, x))


@overload(_measured, jit_options=INLINED)
def _(p, e, x):  # type: ignore[no-untyped-def]
    law = _measured_of(p)
    return (lambda p, e, x: (0.0, -np.inf)) if law is None else (lambda p, e, x: law(p, e, x))


@overload(_near, jit_options=INLINED)
def _(p, e, x, margin):  # type: ignore[no-untyped-def]
    law = _near_of(p)
    return lambda p, e, x, margin: law(p, e, x, margin)


@overload(_rest, jit_options=INLINED)
def _(p, e, x):  # type: ignore[no-untyped-def]
    law = _rest_of(p)
    return lambda p, e, x: law(p, e, x)


@overload(_linked, jit_options=INLINED)
def _(p, x, v, chain, left, by_x, by_v):  # type: ignore[no-untyped-def]
    law = _linked_of(p)
    return lambda p, x, v, chain, left, by_x, by_v: law(p, x, v, chain, left, by_x, by_v)


@overload(_rate, jit_options=INLINED)
def _(p, x, v, share):  # type: ignore[no-untyped-def]
    law = _rate_of(p)
    return lambda p, x, v, share: law(p, x, v, share)


@overload(_between, jit_options=INLINED)
def _(p, e, x, y, f):  # type: ignore[no-untyped-def]
    law = _between_of(p)
    return lambda p, e, x, y, f: law(p, e, x, y, f)


# What elements of any number of nodes have in common


@njit(cache=True, **INLINED)
def _gather(nodes: IntArray, e: int, k: int, of_net: FloatArray, of_element: FloatArray) -> None:
    """Values (k, 3) at the k nodes of an element, from those of all nodes, flat."""
    for a in range(k):
        i = index(nodes[e, a])
        for c in range(3):
            of_element[a, c] = of_net[i + c]


@njit(cache=True, **INLINED)
def _add_wrench(x: FloatArray, c: int, F: float, total: FloatArray) -> None:
    """Add a force F along axis c at x (3,), and its moment about the origin, to the sums."""
    total[FORCE + c] += F
    total[TORQUE + (c + 1) % 3] += x[(c + 2) % 3] * F
    total[TORQUE + (c + 2) % 3] -= x[(c + 1) % 3] * F


@njit(cache=True, **INLINED)
def _settle(el: Elements, k: int, pair: bool, V: FloatArray, at: int, total: FloatArray) -> None:
    """Add the powers of the shares of the last evaluation, at velocities V, to the sums at `at` and after it."""
    lost = brought = 0.0
    nodes, acted, taken, given = el.nodes, el.acted, el.taken, el.given
    dissipates, drives = len(taken) > 0, len(given) > 0
    for q in range(el.counts[ACTED]):
        e = index(acted[q])
        if pair:
            i, j = index(nodes[e, 0]), index(nodes[e, 1])
            for c in range(3):
                w = V[j + c] - V[i + c]
                if dissipates:
                    lost += taken[3 * q + c] * w
                if drives:
                    brought -= given[3 * q + c] * w
        else:
            for a in range(k):
                for c in range(3):
                    own = V[nodes[e, a] + c]
                    if dissipates:
                        lost -= taken[3 * (k * q + a) + c] * own
                    if drives:
                        brought += given[3 * (k * q + a) + c] * own
    total[at] += lost
    total[at + 1] += brought


# Loops


def _add_of_pair(law: Law) -> Any:
    Parameters, version = law.parameters, law.version
    conserves, dissipates, drives = _has(law)
    sifted, watched = law.near is not None, law.measured is not None
    kept = dissipates or drives

    @cfunc(_I(_A, _A, _A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def add(elements, x, v, f, middle, sums):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3 = 3 * len(el.in_space)
        X, V, F = floats(x, n3), floats(v, n3), floats(f, n3)
        total, nodes, s = floats(sums, SUMS), el.nodes, el.signal
        fc, fd, fe = el.room[0:3], el.room[3:6], el.room[6:9]
        shares = Shares(fc, fd, fe)
        tension, strain = total[TENSION], total[STRAIN]
        count, acted, taken, given, lost, brought = 0, el.acted, el.taken, el.given, 0.0, 0.0
        if kept and middle != 0:
            _settle(el, 2, True, floats(middle, n3), TAKEN + FORMER, total)
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            i, j = index(nodes[e, 0]), index(nodes[e, 1])
            d = (X[j] - X[i], X[j + 1] - X[i + 1], X[j + 2] - X[i + 2])
            w = (V[j] - V[i], V[j + 1] - V[i + 1], V[j + 2] - V[i + 2])
            if not _force(p, e, s, d, w, shares):
                continue
            for c in range(3):
                pull = 0.0
                if conserves:
                    pull += fc[c]
                    fc[c] = 0.0
                if dissipates:
                    pull += fd[c]
                    lost += fd[c] * w[c]
                    if middle != 0:
                        taken[3 * count + c] = fd[c]
                    fd[c] = 0.0
                if drives:
                    pull += fe[c]
                    brought -= fe[c] * w[c]
                    if middle != 0:
                        given[3 * count + c] = fe[c]
                    fe[c] = 0.0
                F[i + c] += pull
                F[j + c] -= pull
            if kept and middle != 0:
                acted[count] = e
                count += 1
            if watched:
                square, stretched = _measured(p, e, d)
                tension, strain = max(tension, square), max(strain, stretched)
        total[TENSION], total[STRAIN] = tension, strain
        if kept and middle != 0:
            el.counts[ACTED] = count
            if middle == v:
                total[TAKEN] += lost
                total[GIVEN] += brought
            else:
                _settle(el, 2, True, floats(middle, n3), TAKEN, total)
        return 0

    return add


def _add_of_elements(law: Law) -> Any:
    Parameters, version, k_of_law = law.parameters, law.version, law.nodes
    conserves, dissipates, drives = _has(law)
    from_outside, sifted, watched = law.external, law.near is not None, law.measured is not None
    kept = dissipates or drives

    @cfunc(_I(_A, _A, _A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def add(elements, x, v, f, middle, sums):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3 = 3 * len(el.in_space)
        X, V, F = floats(x, n3), floats(v, n3), floats(f, n3)
        total, nodes, s = floats(sums, SUMS), el.nodes, el.signal
        k = k_of_law if k_of_law > 0 else nodes.shape[1]
        room = el.room.reshape((5, k, 3))
        xe, ve, fc, fd, fe = room[0], room[1], room[2], room[3], room[4]
        shares = Shares(fc, fd, fe)
        tension, strain = total[TENSION], total[STRAIN]
        count, acted, taken, given = 0, el.acted, el.taken, el.given
        if kept and middle != 0:
            _settle(el, k, False, floats(middle, n3), TAKEN + FORMER, total)
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            _gather(nodes, e, k, X, xe)
            _gather(nodes, e, k, V, ve)
            if not _force(p, e, s, xe, ve, shares):
                continue
            for a in range(k):
                i, at = index(nodes[e, a]), 3 * (k * count + a)
                for c in range(3):
                    whole = 0.0
                    if conserves:
                        whole += fc[a, c]
                        fc[a, c] = 0.0
                    if dissipates:
                        whole += fd[a, c]
                        if middle != 0:
                            taken[at + c] = fd[a, c]
                        fd[a, c] = 0.0
                    if drives:
                        whole += fe[a, c]
                        if middle != 0:
                            given[at + c] = fe[a, c]
                        fe[a, c] = 0.0
                    F[i + c] += whole
                    if from_outside and el.in_space[i // 3]:
                        _add_wrench(xe[a], c, whole, total)
            if kept and middle != 0:
                acted[count] = e
                count += 1
            if watched:
                square, stretched = _measured(p, e, xe)
                tension, strain = max(tension, square), max(strain, stretched)
        total[TENSION], total[STRAIN] = tension, strain
        if kept and middle != 0:
            el.counts[ACTED] = count
            _settle(el, k, False, floats(middle, n3), TAKEN, total)
        return 0

    return add


def _settle_of(law: Law) -> Any:
    pair, k_of_law, version = law.pair, law.nodes, law.version

    @cfunc(_I(_A, _A, _A), cache=bool(version), **OPTIONS)
    def settle(elements, v, sums):  # type: ignore[no-untyped-def]
        """Add to the sums the powers of the shares of the last evaluation at velocities v; 0 for both forgets them."""
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        if v == 0:
            el.counts[ACTED] = 0
            return 0
        k = k_of_law if k_of_law > 0 else el.nodes.shape[1]
        _settle(el, k, pair, floats(v, 3 * len(el.in_space)), TAKEN, floats(sums, SUMS))
        return 0

    return settle


def _rates_of_pair(law: Law) -> Any:
    Parameters, version = law.parameters, law.version
    _, dissipates, drives = _has(law)
    sifted, watched, stores = law.near is not None, law.measured is not None, law.energy is not None

    @cfunc(_I(_A, _A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def rates(elements, x, v, sums, wants_energy):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3 = 3 * len(el.in_space)
        X, V = floats(x, n3), floats(v, n3)
        total, nodes, s = floats(sums, SUMS), el.nodes, el.signal
        fc, fd, fe = el.room[0:3], el.room[3:6], el.room[6:9]
        shares = Shares(fc, fd, fe)
        tension, strain, stored, lost, gained = total[TENSION], total[STRAIN], 0.0, 0.0, 0.0
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            i, j = index(nodes[e, 0]), index(nodes[e, 1])
            d = (X[j] - X[i], X[j + 1] - X[i + 1], X[j + 2] - X[i + 2])
            w = (V[j] - V[i], V[j + 1] - V[i + 1], V[j + 2] - V[i + 2])
            if stores and wants_energy != 0:
                stored += _energy(p, e, d)
            if not _force(p, e, s, d, w, shares):
                continue
            for c in range(3):
                fc[c] = 0.0
                if dissipates:
                    lost += fd[c] * w[c]
                    fd[c] = 0.0
                if drives:
                    gained -= fe[c] * w[c]
                    fe[c] = 0.0
            if watched:
                square, stretched = _measured(p, e, d)
                tension, strain = max(tension, square), max(strain, stretched)
        total[TENSION], total[STRAIN] = tension, strain
        total[STORED] += stored
        total[DISSIPATED] += lost
        total[EXTERNAL] += gained
        return 0

    return rates


def _rates_of_elements(law: Law) -> Any:
    Parameters, version, k_of_law = law.parameters, law.version, law.nodes
    _, dissipates, drives = _has(law)
    from_outside, sifted = law.external, law.near is not None
    watched, stores = law.measured is not None, law.energy is not None

    @cfunc(_I(_A, _A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def rates(elements, x, v, sums, wants_energy):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3 = 3 * len(el.in_space)
        X, V = floats(x, n3), floats(v, n3)
        total, nodes, s = floats(sums, SUMS), el.nodes, el.signal
        k = k_of_law if k_of_law > 0 else nodes.shape[1]
        room = el.room.reshape((5, k, 3))
        xe, ve, fc, fd, fe = room[0], room[1], room[2], room[3], room[4]
        shares = Shares(fc, fd, fe)
        tension, strain = total[TENSION], total[STRAIN]
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            _gather(nodes, e, k, X, xe)
            _gather(nodes, e, k, V, ve)
            if stores and wants_energy != 0:
                total[STORED] += _energy(p, e, xe)
            if not _force(p, e, s, xe, ve, shares):
                continue
            for a in range(k):
                in_space = el.in_space[nodes[e, a] // 3]
                for c in range(3):
                    if dissipates:
                        total[DISSIPATED] -= fd[a, c] * ve[a, c]
                    if drives:
                        total[EXTERNAL] += fe[a, c] * ve[a, c]
                    if from_outside and in_space:
                        whole = fc[a, c] + fd[a, c] + fe[a, c]
                        _add_wrench(xe[a], c, whole, total)
                    fc[a, c] = fd[a, c] = fe[a, c] = 0.0
            if watched:
                square, stretched = _measured(p, e, xe)
                tension, strain = max(tension, square), max(strain, stretched)
        total[TENSION], total[STRAIN] = tension, strain
        return 0

    return rates


def _tangents_of_pair(law: Law) -> Any:
    Parameters, version, sifted = law.parameters, law.version, law.near is not None

    @cfunc(_I(_A, _A, _A), cache=bool(version), **OPTIONS)
    def tangents(elements, x, v):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3 = 3 * len(el.in_space)
        X, V, nodes, s = floats(x, n3), floats(v, n3), el.nodes, el.signal
        K, C, Ke, Ce = el.K, el.C, np.zeros((3, 3)), np.zeros((3, 3))
        count = 0
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            i, j = index(nodes[e, 0]), index(nodes[e, 1])
            d = (X[j] - X[i], X[j + 1] - X[i + 1], X[j + 2] - X[i + 2])
            w = (V[j] - V[i], V[j + 1] - V[i + 1], V[j + 2] - V[i + 2])
            if _tangent(p, e, s, d, w, Ke, Ce):
                el.active[count] = e
                for a in range(3):
                    for b in range(3):
                        K[9 * count + 3 * a + b], C[9 * count + 3 * a + b] = Ke[a, b], Ce[a, b]
                        Ke[a, b] = Ce[a, b] = 0.0
                count += 1
        el.counts[ACTIVE] = count
        return 0

    return tangents


def _tangents_of_elements(law: Law) -> Any:
    Parameters, version, k_of_law = law.parameters, law.version, law.nodes
    sifted = law.near is not None

    @cfunc(_I(_A, _A, _A), cache=bool(version), **OPTIONS)
    def tangents(elements, x, v):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3 = 3 * len(el.in_space)
        X, V, nodes, s = floats(x, n3), floats(v, n3), el.nodes, el.signal
        k = k_of_law if k_of_law > 0 else nodes.shape[1]
        xe, ve = np.empty((k, 3)), np.empty((k, 3))
        shape = (len(nodes), k, 3, k, 3)
        K, C = el.K.reshape(shape), el.C.reshape(shape)
        count = 0
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            _gather(nodes, e, k, X, xe)
            _gather(nodes, e, k, V, ve)
            K[count] = 0.0
            C[count] = 0.0
            if _tangent(p, e, s, xe, ve, K[count], C[count]):
                el.active[count] = e
                count += 1
        el.counts[ACTIVE] = count
        return 0

    return tangents


def _tangents_of_links(law: Law) -> Any:
    Parameters, version = law.parameters, law.version

    @cfunc(_I(_A, _A, _A), cache=bool(version), **OPTIONS)
    def tangents(elements, x, v):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3, nodes = 3 * len(el.in_space), el.nodes
        X, V, k = floats(x, n3), floats(v, n3), nodes.shape[1]
        xe, ve = np.empty((k, 3)), np.empty((k, 3))
        _gather(nodes, 0, k, X, xe)
        _gather(nodes, 0, k, V, ve)
        links, rank = len(el.K) // 36, len(el.left) // (3 * k)
        shape = (rank, k, 3)
        chain = el.K.reshape((links, 2, 3, 2, 3))
        acts = _linked(
            p, xe, ve, chain, el.left.reshape(shape), el.by_x.reshape(shape), el.by_v.reshape(shape)
        )
        el.rank[0], el.counts[ACTIVE] = (rank, links) if acts else (0, 0)
        return 0

    return tangents


def _sift_of(law: Law) -> Any:
    Parameters, version, pair, k_of_law = law.parameters, law.version, law.pair, law.nodes

    @cfunc(_I(_A, _A, _D, _D, _A), cache=bool(version), **OPTIONS)
    def sift(elements, x, margin, wide, active):  # type: ignore[no-untyped-def]
        """Find the elements near by `margin`, after those near by `wide` if that is larger, and mark their nodes."""
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n, nodes = len(el.in_space), el.nodes
        X, k = floats(x, 3 * n), k_of_law if k_of_law > 0 else nodes.shape[1]
        xe, moves = el.room.reshape((5, k, 3))[0], flags(active, n)
        for turn in range(0 if wide > margin else 1, 2):
            reach, found = (wide, el.wide) if turn == 0 else (margin, el.near)
            count = 0
            for q in range(len(nodes) if turn == 0 else el.counts[WIDE]):
                e = q if turn == 0 else index(el.wide[q])
                found[count] = e
                if pair:
                    i, j = index(nodes[e, 0]), index(nodes[e, 1])
                    count += _near(p, e, (X[j] - X[i], X[j + 1] - X[i + 1], X[j + 2] - X[i + 2]), reach)
                else:
                    _gather(nodes, e, k, X, xe)
                    count += _near(p, e, xe, reach)
            el.counts[WIDE if turn == 0 else NEAR] = count
        for q in range(el.counts[NEAR] if active != 0 else 0):
            e = el.near[q]
            for a in range(k):
                moves[nodes[e, a] // 3] = True
        return 0

    return sift


def _rests_of(law: Law) -> Any:
    Parameters, version = law.parameters, law.version

    @cfunc(_I(_A, _A, _A), cache=bool(version), **OPTIONS)
    def rests(elements, x, lengths):  # type: ignore[no-untyped-def]
        """Rest lengths (m,), m, if requested; 1 if one is below its `least`, 2 if no flight can continue with one."""
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3, nodes = 3 * len(el.in_space), el.nodes
        X, k, worst = floats(x, n3), nodes.shape[1], 0
        xe = np.empty((k, 3))
        for e in range(len(nodes)):
            _gather(nodes, e, k, X, xe)
            L, end = _rest(p, e, xe)
            if lengths != 0:
                floats(lengths, len(nodes))[e] = L
            if not L > end:
                worst = 2
            elif len(el.least) and not L >= el.least[e]:
                worst = max(worst, 1)
        return worst

    return rests


def _rate_of_friction(law: Law) -> Any:
    Parameters, version = law.parameters, law.version

    @cfunc(_D(_A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def rate(elements, x, v, share):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3, nodes = 3 * len(el.in_space), el.nodes
        X, V, of_node, k = floats(x, n3), floats(v, n3), floats(share, n3), nodes.shape[1]
        xe, ve, of_ring = np.empty((k, 3)), np.empty((k, 3)), np.empty(k)
        total = 0.0
        for e in range(len(nodes)):
            _gather(nodes, e, k, X, xe)
            _gather(nodes, e, k, V, ve)
            for a in range(k):
                of_ring[a] = of_node[nodes[e, a]]
            total += _rate(p, xe, ve, of_ring)
        return total

    return rate


def _at_drum_of(law: Law) -> Any:
    Parameters, version = law.parameters, law.version

    @cfunc(_I(_A, _A, _D, _D, _A), cache=bool(version), **OPTIONS)
    def at_drum(elements, e, place, speed, out):  # type: ignore[no-untyped-def]
        """Add conservative, dissipative and external force along x in N, and ∂f/∂ṡ in N s/m, of one element."""
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        shares_of_drum, s = floats(out, 4), el.signal
        room = el.room.reshape((5, 1, 3))
        x, v, shares = room[0], room[1], Shares(room[2], room[3], room[4])
        K, C = el.K[:9].reshape((1, 3, 1, 3)), el.C[:9].reshape((1, 3, 1, 3))
        for k in range(9):
            el.K[k] = el.C[k] = el.room[6 + k] = 0.0
        x[0, 0], v[0, 0] = place, speed
        x[0, 1] = x[0, 2] = v[0, 1] = v[0, 2] = 0.0
        if _force(p, e, s, x, v, shares):
            shares_of_drum[0] += shares.conservative[0, 0]
            shares_of_drum[1] += shares.dissipative[0, 0]
            shares_of_drum[2] += shares.external[0, 0]
            if _tangent(p, e, s, x, v, K, C):
                shares_of_drum[3] += C[0, 0, 0, 0]
        return 0

    return at_drum


def _between_pair(law: Law) -> Any:
    Parameters, version, sifted = law.parameters, law.version, law.near is not None

    @cfunc(_I(_A, _A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def between(elements, x, y, f, sums):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3, nodes, fc = 3 * len(el.in_space), el.nodes, el.room[0:3]
        X, Y, F = floats(x, n3), floats(y, n3), floats(f, n3)
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            i, j = index(nodes[e, 0]), index(nodes[e, 1])
            d = (X[j] - X[i], X[j + 1] - X[i + 1], X[j + 2] - X[i + 2])
            g = (Y[j] - Y[i], Y[j + 1] - Y[i + 1], Y[j + 2] - Y[i + 2])
            if _between(p, e, d, g, fc):
                for c in range(3):
                    F[i + c] += fc[c]
                    F[j + c] -= fc[c]
                    fc[c] = 0.0
        return 0

    return between


def _between_elements(law: Law) -> Any:
    Parameters, version, k_of_law = law.parameters, law.version, law.nodes
    from_outside, sifted = law.external, law.near is not None

    @cfunc(_I(_A, _A, _A, _A, _A), cache=bool(version), **OPTIONS)
    def between(elements, x, y, f, sums):  # type: ignore[no-untyped-def]
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3, nodes, total = 3 * len(el.in_space), el.nodes, floats(sums, SUMS)
        X, Y, F = floats(x, n3), floats(y, n3), floats(f, n3)
        k = k_of_law if k_of_law > 0 else nodes.shape[1]
        room = el.room.reshape((5, k, 3))
        xe, ye, fc = room[0], room[1], room[2]
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            _gather(nodes, e, k, X, xe)
            _gather(nodes, e, k, Y, ye)
            if not _between(p, e, xe, ye, fc):
                continue
            for a in range(k):
                i = index(nodes[e, a])
                for c in range(3):
                    xe[a, c] = 0.5 * (xe[a, c] + ye[a, c])
                for c in range(3):
                    F[i + c] += fc[a, c]
                    if from_outside and el.in_space[i // 3]:
                        _add_wrench(xe[a], c, fc[a, c], total)
                    fc[a, c] = 0.0
        return 0

    return between


@njit(cache=True, **INLINED)
def _turning(h: float, d: Any, v: Any, g: Any, w: Any) -> tuple[float, Any]:
    """Where in a step from d, v to g, w the length stops growing, as a share of it, and d there; by cubics."""
    rises = h * (d[0] * v[0] + d[1] * v[1] + d[2] * v[2])
    falls = h * (g[0] * w[0] + g[1] * w[1] + g[2] * w[2])
    gain = 0.5 * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2] - d[0] * d[0] - d[1] * d[1] - d[2] * d[2])
    A, B = 3.0 * (rises + falls - 2.0 * gain), 2.0 * (3.0 * gain - 2.0 * rises - falls)
    s = min(max(2.0 * rises / (np.sqrt(max(B * B - 4.0 * A * rises, 0.0)) - B), 0.0), 1.0)
    r = 1.0 - s
    a, b, c, e = r * r * (1.0 + 2.0 * s), s * s * (3.0 - 2.0 * s), h * s * r * r, -h * s * s * r
    return s, (
        a * d[0] + b * g[0] + c * v[0] + e * w[0],
        a * d[1] + b * g[1] + c * v[1] + e * w[1],
        a * d[2] + b * g[2] + c * v[2] + e * w[2],
    )


def _crest_of_pair(law: Law) -> Any:
    Parameters, version, sifted = law.parameters, law.version, law.near is not None

    @cfunc(_I(_A, _A, _A, _A, _A, _D, _A), cache=bool(version), **OPTIONS)
    def crest(elements, x, v, y, w, h, found):  # type: ignore[no-untyped-def]
        """Largest square of tension and strain at y, and inside the step, see `table.find_crests`."""
        version  # noqa: B018  # distinguishes what is cached on disk
        el = load(elements, Elements)
        p: Any = load(el.parameters, Parameters)
        n3, nodes, out = 3 * len(el.in_space), el.nodes, floats(found, 5)
        X, V, Y, W = floats(x, n3), floats(v, n3), floats(y, n3), floats(w, n3)
        for q in range(el.counts[NEAR] if sifted else len(nodes)):
            e = index(el.near[q]) if sifted else q
            i, j = index(nodes[e, 0]), index(nodes[e, 1])
            g = (Y[j] - Y[i], Y[j + 1] - Y[i + 1], Y[j + 2] - Y[i + 2])
            square, stretched = _measured(p, e, g)
            if stretched > 0.0:
                out[0] = max(out[0], square)
            out[1] = max(out[1], stretched)
            u = (W[j] - W[i], W[j + 1] - W[i + 1], W[j + 2] - W[i + 2])
            if g[0] * u[0] + g[1] * u[1] + g[2] * u[2] >= 0.0:
                continue
            d = (X[j] - X[i], X[j + 1] - X[i + 1], X[j + 2] - X[i + 2])
            t = (V[j] - V[i], V[j + 1] - V[i + 1], V[j + 2] - V[i + 2])
            if d[0] * t[0] + d[1] * t[1] + d[2] * t[2] > 0.0:
                s, top = _turning(h, d, t, g, u)
                square, stretched = _measured(p, e, top)
                if stretched > 0.0 and square > out[2]:
                    out[2], out[3] = square, s
                out[4] = max(out[4], stretched)
        return 0

    return crest


def _has(law: Law) -> tuple[bool, bool, bool]:
    return tuple(share in law.shares for share in Shares._fields)  # type: ignore[return-value]


def _made(law: Law, name: str) -> Any:
    match name:
        case "add":
            return _add_of_pair(law) if law.pair else _add_of_elements(law)
        case "rates":
            return _rates_of_pair(law) if law.pair else _rates_of_elements(law)
        case "tangents" if law.newton == "links":
            return _tangents_of_links(law)
        case "tangents" if law.tangent is not None:
            return _tangents_of_pair(law) if law.pair else _tangents_of_elements(law)
        case "sift" if law.near is not None:
            return _sift_of(law)
        case "settle" if "dissipative" in law.shares or "external" in law.shares:
            return _settle_of(law)
        case "rests" if law.rest is not None:
            return _rests_of(law)
        case "rate" if law.rate is not None:
            return _rate_of_friction(law)
        case "between" if law.between is not None:
            return _between_pair(law) if law.pair else _between_elements(law)
        case "crest" if law.pair and law.measured is not None:
            return _crest_of_pair(law)
        case "at_drum" if law.implicit:
            return _at_drum_of(law)
    return None


@cache
def loop_of(law: Law, name: str) -> Any:
    """The compiled C function of that name for a law; None where the law does not have it."""
    return _made(law, name)
