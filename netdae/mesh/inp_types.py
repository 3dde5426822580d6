"""Element types of Abaqus and CalculiX by what a net makes of them."""

from __future__ import annotations

import re
from typing import NamedTuple

LINE, SURFACE, VOLUME, OTHER = "line", "surface", "volume", "other"

_LINES = re.compile(r"(T[23]D|B2|B3|PIPE2|PIPE3)([123])[A-Z]*$|FRAME[23]D$")
_SURFACES = re.compile(
    r"(?:S|SFM3D|M3D|CPS|CPE|CPEG|CAX|CGAX|R3D|DS|DC2D|DCAX|AC2D|ACAX|F3D)([34689])(?!\d)[A-Z0-9]*$"
)
_VOLUMES = re.compile(r"(?:C3D|AC3D|DC3D|DCC3D|COH3D|SC|CSS|GK3D|F?C?3D|CCL)(\d+)[A-Z]*$")


class ElementType(NamedTuple):
    """Kind of an element, and the number of its nodes, 0 where it is not known."""

    kind: str
    nodes: int


def element_type_of(name: str) -> ElementType:
    """What the TYPE of an *ELEMENT stands for; lines are trusses, beams and pipes."""
    name = name.upper()
    if found := _LINES.match(name):
        family, order = found[1], found[2]
        if family is None:
            return ElementType(LINE, 2)
        if family.startswith("T"):
            return ElementType(LINE, 3 if order == "3" else 2)
        return ElementType(LINE, 3 if order == "2" else 2)
    if name.startswith("STRI"):
        return ElementType(SURFACE, 6 if name == "STRI65" else 3)
    if found := _SURFACES.match(name):
        return ElementType(SURFACE, int(found[1]))
    if found := _VOLUMES.match(name):
        return ElementType(VOLUME, int(found[1]))
    return ElementType(OTHER, 0)
