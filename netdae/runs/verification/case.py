"""What a verification case is: its claim, its source, how it is flown, and what its results are compared with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.solvers.options import Accuracy, SolverOptions

Way = Literal["ida", "explicit", "statics", "modes"]
"""A method of a flight, or what finds an equilibrium or its frequencies."""


class Source(NamedTuple):
    """Where a reference was published: the words of a citation, and a link to it (DOI, document) if it has one."""

    words: str
    link: str = ""


class Setting(NamedTuple):
    """One way to fly a case.

    mesh : number of pieces, whatever the case counts; 0 where it has only one mesh
    rtol, max_step : of a refinement; 0 for those of the preset
    """

    method: Way
    mesh: int = 0
    accuracy: Accuracy = "accurate"
    rtol: float = 0.0
    max_step: float = 0.0

    @property
    def label(self) -> str:
        """The setting in a few words."""
        words: list[str] = [self.method]
        words += [f"{self.mesh} pieces"] if self.mesh else []
        if self.method in ("ida", "explicit"):
            words += [f"rtol {self.rtol:g}"] if self.rtol else []
            words += [f"steps of {self.max_step:g} s"] if self.max_step else []
            words += [self.accuracy] if not (self.rtol or self.max_step) else []
        return ", ".join(words)

    def options(self) -> SolverOptions:
        """Options of a flight; a relative tolerance brings the absolute ones, rtol m and 10 rtol m/s."""
        method: Literal["ida", "explicit"] = "explicit" if self.method == "explicit" else "ida"
        longest = self.max_step or None
        if self.rtol and method == "ida":
            return SolverOptions(
                method,
                rtol=self.rtol,
                atol_position=self.rtol,
                atol_velocity=10 * self.rtol,
                max_step=longest,
            )
        return SolverOptions(method, accuracy=self.accuracy, max_step=longest)


@dataclass(frozen=True, eq=False)
class Check:
    """A result beside its reference, numbers or arrays (k,), and what they may differ by.

    tolerance : largest |found − reference|, in `unit`
    reason : of the tolerance
    """

    name: str
    unit: str
    found: FloatArray
    reference: FloatArray
    tolerance: float
    reason: str

    @classmethod
    def of(
        cls,
        name: str,
        unit: str,
        found: Sequence[float] | FloatArray | float,
        reference: Sequence[float] | FloatArray | float,
        *,
        within: float = 0.0,
        relative: float = 0.0,
        reason: str,
    ) -> Check:
        """Compare within a number of the unit, or relative to the largest reference."""
        both = np.broadcast_arrays(*(np.atleast_1d(np.asarray(each, float)) for each in (found, reference)))
        largest = float(np.abs(both[1]).max())
        return cls(name, unit, both[0].ravel(), both[1].ravel(), within or relative * largest, reason)

    @property
    def errors(self) -> FloatArray:
        """|found − reference|, (k,); NaN counts as infinite."""
        return np.nan_to_num(np.abs(self.found - self.reference), nan=np.inf, posinf=np.inf)

    @property
    def error(self) -> float:
        """The largest of the errors."""
        return float(self.errors.max())

    @property
    def worst(self) -> tuple[float, float]:
        """Result and reference where they differ most."""
        k = int(self.errors.argmax())
        return float(self.found[k]), float(self.reference[k])

    @property
    def passes(self) -> bool:
        """Whether all differ by the tolerance at most."""
        return self.error <= self.tolerance


class Curve(NamedTuple):
    """A line in a picture, x and y (k,)."""

    label: str
    x: Any
    y: Any


class Picture(NamedTuple):
    """Reference and result over the same axis; references are drawn as lines, results as markers."""

    x_label: str
    y_label: str
    reference: tuple[Curve, ...]
    found: tuple[Curve, ...]


@dataclass(frozen=True, eq=False)
class Study:
    """What a case gives at one setting."""

    checks: tuple[Check, ...]
    picture: Picture | None = None

    @property
    def passes(self) -> bool:
        """Whether every check passes."""
        return all(check.passes for check in self.checks)

    def require(self) -> None:
        """Raise AssertionError with the checks that fail, for tests."""
        failing = [
            f"{each.name}: {each.worst[0]:.9g} for {each.worst[1]:.9g} {each.unit}, "
            f"off by {each.error:.3g}, at most {each.tolerance:.3g}"
            for each in self.checks
            if not each.passes
        ]
        assert not failing, "; ".join(failing)


class Refinement(NamedTuple):
    """Settings from coarse to fine, and the power of their size that the error of a check should fall with.

    size : name of what is refined
    sizes : of each setting, (k,): the error falls as size ** slope
    within : that the slope may differ by
    """

    size: str
    sizes: tuple[float, ...]
    settings: tuple[Setting, ...]
    check: str
    slope: float
    within: float
    reason: str


@dataclass(frozen=True)
class Case:
    """A claim with a known answer.

    name : in lower case, with dashes
    statement : the claim, a sentence
    fly : gives the results at a setting
    settings : all at which the claim must hold; `quick` those of them that also `--quick` flies
    refinements : what converges, and how
    quick_refinements : whether `--quick` measures them too
    """

    name: str
    title: str
    statement: str
    sources: tuple[Source, ...]
    fly: Callable[[Setting], Study]
    settings: tuple[Setting, ...]
    quick: tuple[Setting, ...]
    refinements: tuple[Refinement, ...] = ()
    quick_refinements: bool = True

    @property
    def methods(self) -> tuple[str, ...]:
        """Methods that it concerns, in the order of the settings."""
        return tuple(dict.fromkeys(setting.method for setting in self.settings))
