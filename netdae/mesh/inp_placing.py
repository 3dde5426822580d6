"""Where an input file of Abaqus puts nodes: coordinate systems, lines of nodes, and moved copies.

Symbols: x a place (3,), m; R a rotation (3, 3); t a translation (3,), so that a moved place is R x + t.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import MeshError
from netdae.mesh.inp_blocks import Block, Line

MOST = 2_000_000
"""Nodes or elements that one line of *NGEN, *NFILL or *ELGEN may make."""


DIGITS = 15
"""Digits of a whole number, at most."""


class Motion(NamedTuple):
    """A rotation R and a translation t."""

    R: FloatArray
    t: FloatArray

    def of(self, x: FloatArray) -> FloatArray:
        """Moved places R x + t, (..., 3)."""
        return np.asarray(x @ self.R.T + self.t)


def stay() -> Motion:
    """The motion that moves nothing."""
    return Motion(np.eye(3), np.zeros(3))


def number(text: str, line: Line) -> float:
    """A number; an empty field is 0 and D an exponent; raises MeshError."""
    try:
        return float(text or 0)
    except ValueError:
        try:
            return float(text.upper().replace("D", "E"))
        except ValueError:
            pass
    if text.startswith("<"):
        raise MeshError(f"{line.where}: {text} is a *PARAMETER, which is not read: write the number")
    raise MeshError(f"{line.where}: {text[:40]!r} is no number: the file is damaged, or edit the line")


def whole(text: str, line: Line) -> int:
    """A whole number; raises MeshError."""
    if text.isdecimal() and len(text) <= DIGITS:
        return int(text)
    value = number(text, line)
    if not abs(value) < 10.0**DIGITS or value != int(value):
        raise MeshError(
            f"{line.where}: {text[:40]!r} is no whole number of up to {DIGITS} digits: edit the line"
        )
    return int(value)


def integers(line: Line, defaults: list[int]) -> list[int]:
    """The leading fields as whole numbers, `defaults` where they are empty or missing."""
    given = line.fields[: len(defaults)]
    given += [""] * (len(defaults) - len(given))
    return [whole(text, line) if text else default for text, default in zip(given, defaults, strict=True)]


def reals(line: Line, count: int) -> FloatArray:
    """`count` numbers, 0 where they are missing."""
    given = [number(text, line) for text in line.fields[:count]]
    return np.array(given + [0.0] * (count - len(given)))


def system_of(block: Block) -> Motion:
    """Motion from the coordinates of a *SYSTEM to the global ones.

    Its first line gives the origin and a point on the X1-axis, the second a point in the plane of X1 and Y1.
    Without the second, Z stays and X1 is projected on the XY plane.
    """
    if not block.lines:
        return stay()
    first = block.lines[0]
    at = reals(first, 6)
    origin = at[:3]
    if len(first.fields) <= 3:
        return Motion(np.eye(3), origin)
    along = at[3:] - origin
    if len(block.lines) > 1:
        across = reals(block.lines[1], 3) - origin
        up = np.cross(along, across)
    else:
        along[2] = 0.0
        up = np.array([0.0, 0.0, 1.0])
    if not (np.linalg.norm(along) > 0 and np.linalg.norm(up) > 0):
        raise MeshError(f"{block}: its points lie on one line: give three points of a plane")
    e1, e3 = along / np.linalg.norm(along), up / np.linalg.norm(up)
    return Motion(np.column_stack([e1, np.cross(e3, e1), e3]), origin)


def shift_of(block: Block) -> Motion:
    """Motion of an *INSTANCE or *NCOPY: a translation, then a rotation about the axis from a to b, in degrees."""
    if not block.lines:
        return stay()
    t = reals(block.lines[0], 3)
    if len(block.lines) < 2:
        return Motion(np.eye(3), t)
    turn = reals(block.lines[1], 7)
    a, axis = turn[:3], turn[3:6] - turn[:3]
    if not np.linalg.norm(axis) > 0:
        if turn[6] == 0:
            return Motion(np.eye(3), t)
        raise MeshError(f"{block}: its axis of rotation has no length: give two different points")
    x, y, z = axis / np.linalg.norm(axis)
    angle = np.deg2rad(turn[6])
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return Motion(R, R @ (t - a) + a)


def global_of(x: FloatArray, block: Block, system: Motion) -> FloatArray:
    """Places (n, 3) of a *NODE block in global coordinates, from its SYSTEM parameter and the *SYSTEM before it."""
    kind = block.options.get("SYSTEM", "R").upper() or "R"
    if kind == "C":
        angle = np.deg2rad(x[:, 1])
        x = np.column_stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]])
    elif kind != "R":
        raise MeshError(
            f"{block}, SYSTEM={kind} is not read: give the nodes in coordinates x, y, z or r, θ, z"
        )
    return system.of(x)


def between(first: FloatArray, last: FloatArray, pieces: int) -> FloatArray:
    """Places inside the straight line that `pieces` equal pieces make, (pieces − 1, 3)."""
    s = np.arange(1, pieces)[:, None] / pieces
    return (1 - s) * first + s * last


def limited(count: int, line: Line) -> int:
    """`count` of generated things; raises MeshError where it is not plausible."""
    if not 0 <= count <= MOST:
        raise MeshError(f"{line.where} makes {count} nodes or elements: the limit is {MOST}, edit the line")
    return count
