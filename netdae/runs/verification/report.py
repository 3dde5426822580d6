"""What a report shows, as words and numbers in tables: the same for Markdown and HTML."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date

from netdae.runs.verification.case import Check
from netdae.runs.verification.flown import FlownCase
from netdae.runs.verification.peers import PeerRow

TITLE = "Verification of netdae"
ABOUT = "What netdae computes beside theory and published results, case by case."
HEAD = ("case", "by", "checks", "largest error, of its tolerance", "slopes", "time, s", "result")
CHECK_HEAD = (
    "setting",
    "compared",
    "netdae",
    "reference",
    "unit",
    "error",
    "tolerance",
    "its reason",
    "result",
)
SLOPE_HEAD = ("refined", "error of", "errors, coarse to fine", "slope", "expected", "its reason", "result")
PEER_HEAD = ("code", "settings", "bullets, mm", "mouth, %", "energy, %", "steps", "seconds")


@dataclass(frozen=True, eq=False)
class Report:
    """All cases flown, in their order, and how: `about` has a line each; `peers` is None where not requested."""

    cases: tuple[FlownCase, ...]
    about: tuple[str, ...]
    peers: tuple[PeerRow, ...] | None = None

    @property
    def failing(self) -> tuple[FlownCase, ...]:
        """The cases that fail."""
        return tuple(each for each in self.cases if not each.passes)

    @property
    def verdict(self) -> str:
        """One sentence."""
        if self.failing:
            names = ", ".join(each.name for each in self.failing)
            return f"{len(self.failing)} of {len(self.cases)} cases fail: {names}."
        return f"All {len(self.cases)} cases pass." if len(self.cases) > 1 else "The case passes."


def about_lines(quick: bool, seconds: float, processes: int) -> tuple[str, ...]:
    """How and with what the report was made."""
    from netdae.runs.summary import versions

    command = "netdae verify --quick" if quick else "netdae verify"
    used = ", ".join(f"{name} {version}" for name, version in versions().items())
    return (
        f"Made by {command} on {date.today().isoformat()} in {seconds:.0f} s, in {processes} "
        f"process{'es' if processes > 1 else ''}, on {platform.system()} {platform.machine()}.",
        f"{used}.",
        "Results are computed when the report is made; of references only those with a published source are typed in.",
    )


def result_of(passes: bool) -> str:
    """One word."""
    return "passes" if passes else "FAILS"


def summary_rows(report: Report) -> list[tuple[str, ...]]:
    """A row a case, as in `HEAD`."""
    return [_summary_row(each) for each in report.cases]


def _summary_row(flown: FlownCase) -> tuple[str, ...]:
    checks = [check for _, study in flown.studies for check in study.checks]
    good = sum(check.passes for check in checks)
    shares = [share_of(check) for check in checks]
    return (
        flown.name,
        ", ".join(flown.case.methods),
        f"{good} of {len(checks)}",
        f"{max(shares):.2g}" if shares else "none",
        ", ".join(f"{each.slope:.2f} ({each.refinement.slope:g})" for each in flown.slopes) or "none",
        f"{flown.seconds:.1f}",
        result_of(flown.passes),
    )


def share_of(check: Check) -> float:
    """Error as a share of the tolerance."""
    if check.tolerance > 0:
        return check.error / check.tolerance
    return 0.0 if check.error == 0 else float("inf")


def check_rows(flown: FlownCase) -> list[tuple[str, ...]]:
    """A row a check at each setting, as in `CHECK_HEAD`; result and reference where they differ most."""
    return [
        (
            setting.label,
            check.name,
            f"{check.worst[0]:.8g}",
            f"{check.worst[1]:.8g}",
            check.unit,
            f"{check.error:.2g}",
            f"{check.tolerance:.2g}",
            check.reason,
            result_of(check.passes),
        )
        for setting, study in flown.studies
        for check in study.checks
    ]


def slope_rows(flown: FlownCase) -> list[tuple[str, ...]]:
    """A row a refinement, as in `SLOPE_HEAD`."""
    rows: list[tuple[str, ...]] = []
    for each in flown.slopes:
        wanted = each.refinement
        sizes = ", ".join(f"{size:g}" for size in wanted.sizes)
        rows.append(
            (
                f"{wanted.size}: {sizes} ({wanted.settings[0].method})",
                wanted.check,
                ", ".join(f"{error:.2g}" for error in each.errors),
                f"{each.slope:.3f}",
                f"{wanted.slope:g} ± {wanted.within:g}",
                wanted.reason,
                result_of(each.passes),
            )
        )
    return rows


def peer_rows(peers: Sequence[PeerRow]) -> list[tuple[str, ...]]:
    """A row a code, as in `PEER_HEAD`; one that is not installed says so."""
    return [each.words for each in peers]
