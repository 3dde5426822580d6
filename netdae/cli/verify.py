"""`netdae verify`: fly the verification cases and write a report of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from netdae.cli.arguments import WholeNumber, place
from netdae.core.errors import InputError, RunError

if TYPE_CHECKING:
    from netdae.runs.verification.flown import FlownCase
    from netdae.runs.verification.report import Report


def verify(
    *,
    output: Annotated[
        Path,
        Parameter(name=["--output", "-o"], converter=place, help="Folder for the report."),
    ] = Path("verification"),
    quick: Annotated[
        bool, Parameter(negative="", help="Fly fewer settings of each case: under 40 s on two cores.")
    ] = False,
    case: Annotated[
        list[str] | None, Parameter(negative="", help="Fly this case alone; more by giving it again.")
    ] = None,
    peers: Annotated[
        bool, Parameter(negative="", help="Fly a net in MuJoCo and Exudyn too, where they are installed.")
    ] = False,
    processes: Annotated[
        WholeNumber | None, Parameter(help="Number of processes; by default one for each processor.")
    ] = None,
) -> None:
    """Fly the verification cases and write report.html and report.md; the exit code is 1 if a case fails."""
    import logging
    import time

    from netdae.core.compilation import COMPILING, reported_when_compiling
    from netdae.runs.verification.flown import all_flown, compile_kernels
    from netdae.runs.verification.peers import peers_flown
    from netdae.runs.verification.registry import all_cases, case_named
    from netdae.runs.verification.report import Report, about_lines
    from netdae.runs.workers import processes_for

    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it would report its caches
    cases = [case_named(name) for name in dict.fromkeys(case)] if case else list(all_cases().values())
    workers = processes_for(len(cases), processes)
    _claim(output)
    began = time.monotonic()
    if workers > 1:
        with reported_when_compiling(lambda: print(COMPILING, flush=True)):
            compile_kernels()
    by_name: dict[str, FlownCase] = {}
    for flown in all_flown(cases, quick=quick, processes=workers):
        by_name[flown.name] = flown
        print(_line_of(flown), flush=True)
    rows = None
    if peers:
        rows = peers_flown(quick=quick)
        for row in rows:
            print("peer    " + "  ".join(row.words), flush=True)
    ordered = tuple(by_name[each.name] for each in cases)
    report = Report(ordered, about_lines(quick, time.monotonic() - began, workers), rows)
    _write(report, output)
    print(f"{report.verdict} The report is {output / 'report.html'}")
    if report.failing:
        raise RunError(f"{report.verdict} See {output / 'report.html'}")


def _claim(output: Path) -> None:
    """Make the folder before anything is flown."""
    from netdae.core.files import reason_of

    try:
        output.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError(f"{output} is a file: give a folder for the report with -o") from None
    except OSError as error:
        raise InputError(
            f"{output} cannot be made: {reason_of(error)}: give another folder with -o"
        ) from None


def _write(report: Report, output: Path) -> None:
    from netdae.core.files import reason_of, write_whole
    from netdae.runs.verification.markdown import markdown_of
    from netdae.visual.report.html import html_of

    for name, text in (("report.html", html_of(report)), ("report.md", markdown_of(report))):
        try:
            write_whole(output / name, text.encode("utf-8"))
        except OSError as error:
            raise RunError(f"{output / name} cannot be written: {reason_of(error)}") from None


def _line_of(flown: FlownCase) -> str:
    from netdae.runs.verification.report import result_of, share_of

    if flown.failure:
        return f"{result_of(False)}   {flown.name}: {flown.failure}"
    checks = [check for _, study in flown.studies for check in study.checks]
    worst = max(checks, key=share_of)
    words = f"{len(checks)} checks, largest error {share_of(worst):.2g} of its tolerance"
    slopes = f", slopes {', '.join(f'{each.slope:.2f}' for each in flown.slopes)}" if flown.slopes else ""
    return f"{result_of(flown.passes):<7} {flown.name}: {words}{slopes}, {flown.seconds:.1f} s"
