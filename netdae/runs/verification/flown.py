"""Cases flown at their settings, with the slopes of their refinements, in one process or several."""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from netdae.core.errors import NetdaeError
from netdae.runs.verification.case import Case, Refinement, Setting, Study
from netdae.runs.verification.registry import case_named
from netdae.runs.workers import Tell, outcomes_of


@dataclass(frozen=True)
class Slope:
    """Errors of a refinement, and the slope fitted to their logarithms."""

    refinement: Refinement
    errors: tuple[float, ...]
    slope: float

    @property
    def passes(self) -> bool:
        """Whether the slope is the expected one."""
        return abs(self.slope - self.refinement.slope) <= self.refinement.within


@dataclass(frozen=True, eq=False)
class FlownCase:
    """All results of a case.

    failure : why the case could not be flown, empty if it was
    """

    name: str
    studies: tuple[tuple[Setting, Study], ...] = ()
    slopes: tuple[Slope, ...] = ()
    seconds: float = 0.0
    failure: str = ""

    @property
    def case(self) -> Case:
        """The case itself."""
        return case_named(self.name)

    @property
    def passes(self) -> bool:
        """Whether it was flown, and every check and slope is as it should be."""
        parts = [*(study.passes for _, study in self.studies), *(slope.passes for slope in self.slopes)]
        return not self.failure and bool(parts) and all(parts)


def slope_of(case: Case, refinement: Refinement) -> Slope:
    """Fly a refinement and fit its slope."""
    errors = tuple(_error(case.fly(setting), refinement.check) for setting in refinement.settings)
    if not all(0 < each < np.inf for each in errors):
        return Slope(refinement, errors, np.nan)
    return Slope(refinement, errors, float(np.polyfit(np.log(refinement.sizes), np.log(errors), 1)[0]))


def _error(study: Study, name: str) -> float:
    (check,) = (each for each in study.checks if each.name == name)
    return check.error


def flown(case: Case, *, quick: bool = False) -> FlownCase:
    """Fly one case here. What it raises is its failure: a report shows it beside the others."""
    began = time.perf_counter()
    settings = case.quick if quick else case.settings
    refinements = case.refinements if case.quick_refinements or not quick else ()
    try:
        studies = tuple((setting, case.fly(setting)) for setting in settings)
        slopes = tuple(slope_of(case, each) for each in refinements)
    except (NetdaeError, ArithmeticError, AssertionError, ValueError) as error:
        words = " ".join(f"{type(error).__name__}: {error}".split())
        return FlownCase(case.name, seconds=time.perf_counter() - began, failure=words)
    return FlownCase(case.name, studies, slopes, time.perf_counter() - began)


def _fly_and_send(item: tuple[str, bool], tell: Tell) -> None:
    name, quick = item
    tell(flown(case_named(name), quick=quick))


def all_flown(cases: Sequence[Case], *, quick: bool, processes: int) -> Generator[FlownCase, None, None]:
    """Fly the cases in that many processes and yield each as it ends; one process is this one."""
    if processes == 1:
        yield from (flown(case, quick=quick) for case in cases)
        return
    ended: dict[int, FlownCase] = {}
    items = [(case.name, quick) for case in cases]
    for outcome in outcomes_of(_fly_and_send, items, processes=processes, hear=ended.__setitem__):
        failure = outcome.error or "its process sent nothing"
        yield ended.get(outcome.number) or FlownCase(cases[outcome.number].name, failure=failure)


def compile_kernels() -> None:
    """Compile the kernels of both methods here, so that processes started later only load them."""
    flown(case_named("whirling-ring"), quick=True)
