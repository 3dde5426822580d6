"""A force as one law: its parameters, and compiled functions of one element.

An element has k nodes. Symbols, in functions of one element e: p the parameters; s (3,) the law's signal now, zero
where it has none; x, v (k, 3) positions and velocities of its nodes; f its `Shares`, zero when the function is called.

    force(p, e, s, x, v, f) -> bool      adds the force on each node, N; False where the element does not act
    tangent(p, e, s, x, v, K, C) -> bool    adds ∂f/∂x and ∂f/∂v, (k, 3, k, 3); False where both are zero
    energy(p, e, x) -> float             stored energy, J

A pair is an element of two nodes i and j that depends only on d = xⱼ − xᵢ and w = vⱼ − vᵢ, tuples of three numbers. It
gives the force on i, (3,), and its negative acts on j, so momentum is always conserved. Its functions take d and w in
place of x and v; its tangent is K = ∂f/∂d and C = ∂f/∂w, (3, 3).

Everything else is built from these: see `loops`, and `table` for all forces of a net.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.compilation import INLINED
from netdae.core.sources import Sources

NewtonPart = Literal["symmetric", "links", "nothing"]
Share = Literal["conservative", "dissipative", "external"]

PACKAGE = "netdae"


def compiled(function: Callable[..., Any]) -> Any:
    """A compiled function of a law; cached on disk if it is netdae's own, whose changes are detected."""
    kept = function.__module__.partition(".")[0] == PACKAGE
    return njit(cache=kept, **INLINED)(function)


class Shares(NamedTuple):
    """Parts of a force, each (k, 3), or (3,) for a pair, N.

    conservative : minus the gradient of the stored energy
    dissipative : takes energy out of the motion; external : exchanges it with the outside
    """

    conservative: FloatArray
    dissipative: FloatArray
    external: FloatArray


Vector = tuple[float, float, float]
"""d or w of a pair."""


class Family(NamedTuple):
    """Elements as a stable explicit step sees them, see `explicit.stable_step`.

    nodes : (m, k)
    of_nodes : k in N/m and c in N s/m with which each counts at each node, (2, m, k)
    weight : (m, k) or a number, with which the sums of its nodes count for each
    """

    nodes: IntArray
    of_nodes: FloatArray
    weight: FloatArray | float = 1.0


def no_bound(parameters: Any, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    """For laws that do not bound an explicit step."""
    return []


def _no_links(parameters: Any, nodes: IntArray) -> IntArray:
    return np.zeros((0, 2), dtype=np.int64)


def _no_dyads(parameters: Any) -> int:
    return 0


def _always(parameters: Any) -> bool:
    return True


@dataclass(frozen=True, eq=False)
class Law:
    """A force as data: the class of its parameters, and its functions; see the module.

    parameters : a NamedTuple class; arrays have one row per element
    nodes : k; 0 for one element of any number of nodes
    pair : whether it depends on d and w alone
    shares : those that it has
    external : True if it acts from outside and so changes the net's momentum
    newton : the part of its tangent that the Newton matrix takes, see `force.Force`
    measured : (p, e, x) -> square of the tension in N² and strain, of an element that acts: the monitored quantities
    near : (p, e, x, margin) -> False where it cannot act before two nodes have moved `margin` m relative to each other
    rest : (p, e, x) -> current rest length, m, of what a reel winds in, and the least with which a flight can continue
    linked : (p, x, v, chain, left, by_x, by_v) -> bool, the tangent of a force with links, see `force.LinkedTangent`
    named : (nodes,) of an element -> its name in messages about `rest`
    links, ranks : (parameters, nodes) -> nodes (p, 2) that its blocks couple, and (parameters) -> how many dyads it has
    rate : (p, x, v, share) -> rate of its friction, 1/s, on nodes of 1/mass (k,), where it bounds an explicit step
    implicit : whether an explicit step evaluates it at the end of the step, along x of drums, whatever its stiffness
    steady : whether its tangent is a constant ∂f/∂v
    ranked : (parameters, D) -> name, force in N and formula for the ranking of forces on a net that moves by D in m
    between : (p, e, x, y, f) -> bool, adds the mean force between two places to f, (k, 3) or (3,): the negative stored
        energy's difference is its work, along the mean d it keeps both momenta; see `explicit.discrete_gradient`
    lossless : (parameters) -> whether `between` is the whole force
    bound : (parameters, nodes, strain, x) -> what the stable explicit step sees of it while no E11 passes `strain`;
        None takes the current tangent, which suffices for forces that change slowly
    across : whether it acts across the cords, so that its bound and theirs do not add up
    """

    parameters: type
    force: Any
    tangent: Any = None
    energy: Any = None
    nodes: int = 2
    pair: bool = False
    shares: tuple[Share, ...] = ("conservative",)
    external: bool = False
    newton: NewtonPart = "symmetric"
    measured: Any = None
    near: Any = None
    rest: Any = None
    named: Callable[[IntArray], str] = str
    linked: Any = None
    links: Callable[[Any, IntArray], IntArray] = _no_links
    ranks: Callable[[Any], int] = _no_dyads
    rate: Any = None
    implicit: bool = False
    steady: bool = False
    ranked: Callable[[Any, float], tuple[str, float, str]] | None = None
    between: Any = None
    lossless: Callable[[Any], bool] = _always
    bound: Callable[[Any, IntArray, float, FloatArray], list[Family]] | None = None
    across: bool = False

    def __post_init__(self) -> None:
        LAWS[self.parameters] = self

    @cached_property
    def version(self) -> str:
        """Version of the source that it is compiled from; empty where nothing is cached on disk."""
        return version_of(self.parameters.__module__)


LAWS: dict[type, Law] = {}
"""The law of each class of parameters."""


@cache
def version_of(module: str) -> str:
    """Hash of the source of a module of netdae and of all that it imports from netdae; empty for others."""
    package, *parts = module.split(".")
    own = os.path.join(_FOLDER, *parts) + ".py"
    if package != PACKAGE or not os.path.isfile(own):
        return ""
    digest = hashlib.sha256()
    for path in sorted(_SOURCES.closure_of(own)):
        with open(path, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()[:16]


_FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_SOURCES = Sources(_FOLDER)
