"""The report as one HTML file: no script, no font and no picture from elsewhere, and good to print."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from html import escape

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
    result_of,
    slope_rows,
    summary_rows,
)
from netdae.visual.plotting.comparison import svg_of

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #111; max-width: 74rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; margin-bottom: .3rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .2rem; border-top: 1px solid #bbb; padding-top: 1rem; }
p { margin: .3rem 0; }
.about, .source { color: #444; font-size: .87rem; }
.verdict { font-size: 1.1rem; font-weight: 600; }
table { border-collapse: collapse; width: 100%; margin: .8rem 0; font-size: .83rem; }
th, td { text-align: left; padding: .22rem .5rem; border-bottom: 1px solid #ddd; vertical-align: top; }
th { border-bottom: 1.5px solid #555; }
td { font-variant-numeric: tabular-nums; }
.number, .passes, .FAILS { white-space: nowrap; }
.passes { color: #00683f; } .FAILS { color: #b00020; font-weight: 700; }
figure.picture { margin: .6rem 0; }
.picture svg { max-width: 34rem; width: 100%; height: auto; }
a { color: #0b4f8a; }
@media print {
  @page { size: A4 landscape; margin: 12mm; }
  body { font-size: 9.5pt; max-width: none; margin: 0; padding: 0; }
  table { font-size: 7.8pt; } thead { display: table-header-group; }
  tr, .picture, .claim { break-inside: avoid; } h2 { break-after: avoid; }
  a { color: inherit; text-decoration: none; }
}
"""


def html_of(report: Report) -> str:
    """The whole page."""
    return "\n".join(_lines(report)) + "\n"


def _lines(report: Report) -> Iterator[str]:
    yield '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<title>{TITLE}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{TITLE}</h1>\n<p>{ABOUT}</p>"
    yield f'<p class="verdict {result_of(not report.failing)}">{escape(report.verdict)}</p>'
    yield from (f'<p class="about">{escape(line)}</p>' for line in report.about)
    yield from _table(HEAD, summary_rows(report), linked=True)
    if report.peers is not None:
        yield f'<h2 id="peers">Other codes</h2>\n<p class="claim">{escape(ABOUT_PEERS)}</p>'
        yield from _table(PEER_HEAD, peer_rows(report.peers))
    for flown in report.cases:
        yield from _case(flown)
    yield "</body>\n</html>"


def _case(flown: FlownCase) -> Iterator[str]:
    case = flown.case
    yield f'<h2 id="{escape(case.name)}">{escape(case.title)}</h2>\n<p class="claim">{escape(case.statement)}</p>'
    for source in case.sources:
        link = escape(source.link)
        shown = f', <a href="{link}">{link}</a>' if link else ""
        yield f'<p class="source">Source: {escape(source.words)}{shown}</p>'
    if flown.failure:
        yield f'<p class="FAILS">FAILS: it could not be flown: {escape(flown.failure)}</p>'
        return
    for number, (setting, study) in enumerate(flown.studies):
        if study.picture is not None and number == _shown(flown):
            yield f'<figure class="picture">{_inlined(svg_of(study.picture), case.name)}'
            yield f'<figcaption class="source">Reference and result: {escape(setting.label)}.</figcaption></figure>'
    yield from _table(CHECK_HEAD, check_rows(flown))
    if flown.slopes:
        yield from _table(SLOPE_HEAD, slope_rows(flown))


def _shown(flown: FlownCase) -> int:
    """The study whose picture is shown: the first that fails, else the first that was flown."""
    for number, (_, study) in enumerate(flown.studies):
        if not study.passes and study.picture is not None:
            return number
    flights = [n for n, (setting, _) in enumerate(flown.studies) if setting.method in ("ida", "explicit")]
    return flights[0] if flights else len(flown.studies) - 1


def _inlined(svg: str, name: str) -> str:
    """The SVG element alone, its names made those of this case, so that no two pictures of the page share one."""
    element = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    element = re.sub(r'\bid="', f'id="{name}-', element)
    element = re.sub(r'href="#', f'href="#{name}-', element)
    return re.sub(r"url\(#", f"url(#{name}-", element).strip()


def _kind_of(cell: str) -> str:
    """The class of a cell that is a number, which is not broken into two lines."""
    return ' class="number"' if re.fullmatch(r"[-+]?[0-9.]+(e[-+]?[0-9]+)?( ± [0-9.]+)?", cell) else ""


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], *, linked: bool = False) -> Iterator[str]:
    yield (
        "<table>\n<thead><tr>"
        + "".join(f"<th>{escape(name)}</th>" for name in head)
        + "</tr></thead>\n<tbody>"
    )
    for row in rows:
        cells = [escape(cell) for cell in row]
        if linked:
            cells[0] = f'<a href="#{cells[0]}">{cells[0]}</a>'
        marked = f' class="{row[-1]}"' if row[-1] in ("passes", "FAILS") else ""
        yield (
            "<tr>"
            + "".join(f"<td{_kind_of(cell)}>{cell}</td>" for cell in cells[:-1])
            + f"<td{marked}>{cells[-1]}</td></tr>"
        )
    yield "</tbody>\n</table>"
