"""The report as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from netdae.runs.verification.flown import FlownCase
from netdae.runs.verification.peers import ABOUT_PEERS
from netdae.runs.verification.report import (
    ABOUT,
    CHECK_HEAD,
    HEAD,
    PEER_HEAD,
    SLOPE_HEAD,
    TITLE,
    Report,
    check_rows,
    peer_rows,
    slope_rows,
    summary_rows,
)


def markdown_of(report: Report) -> str:
    """The whole report."""
    return "\n".join(_lines(report)) + "\n"


def _lines(report: Report) -> Iterator[str]:
    yield f"# {TITLE}\n\n{ABOUT}\n\n**{report.verdict}**\n"
    yield from (f"{line}  " for line in report.about)
    yield ""
    rows = [
        (f"[{row[0]}](#{_slug_of(flown.case.title)})", *row[1:])
        for flown, row in zip(report.cases, summary_rows(report), strict=True)
    ]
    yield from _table(HEAD, rows)
    if report.peers is not None:
        yield "\n## Other codes\n"
        yield ABOUT_PEERS + "\n"
        yield from _table(PEER_HEAD, peer_rows(report.peers))
    for flown in report.cases:
        yield from _case(flown)


def _case(flown: FlownCase) -> Iterator[str]:
    case = flown.case
    yield f"\n## {case.title}\n"
    yield case.statement + "\n"
    for source in case.sources:
        yield f"- Source: {source.words}{f', <{source.link}>' if source.link else ''}"
    yield ""
    if flown.failure:
        yield f"**FAILS**: it could not be flown: {flown.failure}\n"
        return
    yield from _table(CHECK_HEAD, check_rows(flown))
    if flown.slopes:
        yield ""
        yield from _table(SLOPE_HEAD, slope_rows(flown))


def _slug_of(title: str) -> str:
    """The anchor that a repository site gives to a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

    yield line(head)
    yield line(["---"] * len(head))
    yield from (line(row) for row in rows)
