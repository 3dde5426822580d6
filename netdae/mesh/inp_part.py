"""Nodes, elements and sets of one part of an input file of Abaqus, from the keywords that place or group something.

A label is what the file calls a node or an element: a number, or INSTANCE.NUMBER.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import chain
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import MeshError
from netdae.mesh.inp_blocks import Block, Line
from netdae.mesh.inp_placing import (
    Motion,
    between,
    global_of,
    integers,
    limited,
    reals,
    shift_of,
    stay,
    system_of,
    whole,
)
from netdae.mesh.inp_types import LINE, ElementType, element_type_of

Label = int | str


class Element(NamedTuple):
    """An element: its type in the file, what that is, and the labels of its nodes."""

    name: str
    type: ElementType
    nodes: list[Label]


@dataclass
class Members:
    """A set: its name as first written, numbers, and names of labels or other sets with their instance ("")."""

    name: str
    numbers: list[range | list[int]] = field(default_factory=list)
    others: list[tuple[str, str]] = field(default_factory=list)
    of_instance: list[tuple[str, range | list[int]]] = field(default_factory=list)
    of_elements: list[str] = field(default_factory=list)


@dataclass
class Part:
    """What the blocks of a part have made so far."""

    nodes: dict[int, FloatArray] = field(default_factory=dict)
    elements: dict[int, Element] = field(default_factory=dict)
    node_sets: dict[str, Members] = field(default_factory=dict)
    element_sets: dict[str, Members] = field(default_factory=dict)
    system: Motion = field(default_factory=stay)

    def take(self, block: Block) -> bool:
        """Do what a block says; False for a keyword that places and groups nothing."""
        action = _ACTIONS.get(block.keyword)
        if action:
            action(self, block)
        return action is not None


def key_of(name: str) -> str:
    """By which a name is found: quoted names keep their case."""
    return name.strip('"') if name.startswith('"') else name.upper()


def members_of(sets: dict[str, Members], name: str) -> Members:
    """The set of a name, made where there is none."""
    return sets.setdefault(key_of(name), Members(name.strip('"')))


def numbers_in(sets: dict[str, Members], name: str, block: Block) -> list[int]:
    """Sorted numbers of a set of this part; raises MeshError where it is missing."""
    found = sets.get(key_of(name))
    if found is None:
        raise MeshError(f"{block}: there is no set {name} before it: define it first")
    inner = [numbers_in(sets, other, block) for instance, other in found.others if not instance]
    return sorted({*chain.from_iterable(found.numbers), *chain.from_iterable(inner)})


def _system(part: Part, block: Block) -> None:
    part.system = system_of(block)


def _nodes(part: Part, block: Block) -> None:
    if not block.lines:
        return
    numbers = [whole(line.fields[0], line) for line in block.lines]
    x = np.array([reals(Line(line.fields[1:], line.where, False), 3) for line in block.lines])
    x = global_of(x, block, part.system)
    for number, line, place in zip(numbers, block.lines, x, strict=True):
        known = part.nodes.setdefault(number, place)
        if known is not place and not np.array_equal(known, place):
            raise MeshError(f"{line.where}: node {number} is given a second time at another place: keep one")
    _into(part.node_sets, block, "NSET", numbers)


def _into(sets: dict[str, Members], block: Block, key: str, numbers: list[int]) -> None:
    if block.options.get(key):
        members_of(sets, block.options[key]).numbers.append(numbers)


def _node(part: Part, number: int, line: Line) -> FloatArray:
    if number not in part.nodes:
        raise MeshError(f"{line.where}: there is no node {number} before this line: give it by *NODE first")
    return part.nodes[number]


def _node_lines(part: Part, block: Block) -> None:
    for key, usual in (("LINE", "S"), ("SYSTEM", "R")):
        if block.options.get(key, usual).upper() not in ("", usual):
            raise MeshError(f"{block}, {key}={block.options[key]} is not read: only straight lines are")
    for line in block.lines:
        first, last, step = integers(line, [0, 0, 1])
        ends = _node(part, first, line), _node(part, last, line)
        step = abs(step) if last > first else -abs(step)
        if step == 0 or (last - first) % step:
            raise MeshError(
                f"{line.where}: steps of {step} do not lead from node {first} to {last}: edit the line"
            )
        pieces = limited((last - first) // step, line)
        inside = [first + k * step for k in range(1, pieces)]
        part.nodes.update(zip(inside, between(*ends, pieces), strict=True))
        _into(part.node_sets, block, "NSET", [first, *inside, last])


def _fill(part: Part, block: Block) -> None:
    _only(block, "NSET")
    for line in block.lines:
        names = line.fields[:2]
        pieces, step = integers(Line(line.fields[2:], line.where, False), [1, 1])
        first, last = (numbers_in(part.node_sets, name, block) for name in names)
        if len(first) != len(last):
            raise MeshError(
                f"{line.where}: the sets {names[0]} and {names[1]} have {len(first)} and {len(last)} nodes: "
                "give as many to both"
            )
        limited(pieces * len(first), line)
        for a, b in zip(first, last, strict=True):
            inside = [a + k * step for k in range(1, pieces)]
            x = between(_node(part, a, line), _node(part, b, line), pieces)
            part.nodes.update(zip(inside, x, strict=True))
            _into(part.node_sets, block, "NSET", [a, *inside, b])


def _copy_nodes(part: Part, block: Block) -> None:
    _only(block, "CHANGE NUMBER", "OLD SET", "NEW SET", "SHIFT")
    if "SHIFT" not in block.options:
        raise MeshError(f"{block} without SHIFT is not read: write the nodes out")
    change = whole(block.options.get("CHANGE NUMBER", ""), Line([], block.where, False))
    old = numbers_in(part.node_sets, block.options.get("OLD SET", ""), block)
    motion = shift_of(block)
    here = Line([], block.where, False)
    part.nodes.update({number + change: motion.of(_node(part, number, here)) for number in old})
    _into(part.node_sets, block, "NEW SET", [number + change for number in old])


def _elements(part: Part, block: Block) -> None:
    name = block.options.get("TYPE", "")
    if not name:
        raise MeshError(f"{block} has no TYPE: add one, such as TYPE=T3D2")
    if block.options.get("FILE"):
        raise MeshError(f"{block}, FILE={block.options['FILE']} is not read: write the elements out")
    kind = element_type_of(name)
    shift = whole(block.options.get("OFFSET", ""), Line([], block.where, False))
    made = []
    pending: list[Label] = []
    line = None
    for line in block.lines:
        pending += [_label(text, line) for text in line.fields if text]
        # a line that ends with a comma goes on, and so does an element that lacks nodes of its type
        if len(pending) <= kind.nodes or (line.goes_on and not kind.nodes):
            continue
        if kind.kind == LINE and kind.nodes and len(pending) > kind.nodes + 2:
            raise MeshError(
                f"{line.where}: element {pending[0]} of type {name} has {len(pending) - 1} nodes, expected "
                f"{kind.nodes}: edit the line"
            )
        made.append(_element(part, pending, name, kind, line, shift))
        pending = []
    if pending and line is not None:
        if kind.nodes:
            raise MeshError(
                f"{line.where}: element {pending[0]} of type {name} has {len(pending) - 1} of {kind.nodes} nodes: "
                "the file is cut off, save it again"
            )
        made.append(_element(part, pending, name, kind, line, shift))
    _into(part.element_sets, block, "ELSET", made)


def _element(part: Part, fields: list[Label], name: str, kind: ElementType, line: Line, shift: int) -> int:
    number, *nodes = fields
    if not isinstance(number, int):
        raise MeshError(f"{line.where}: {number!r} is no number of an element: edit the line")
    new = Element(name, kind, nodes[: kind.nodes] if kind.nodes else nodes)
    if part.elements.setdefault(number + shift, new).nodes != new.nodes:
        raise MeshError(f"{line.where}: element {number} is given a second time with other nodes: keep one")
    return number + shift


def _label(text: str, line: Line) -> Label:
    return text if "." in text and not text[0].isdecimal() else whole(text, line)


def _element_rows(part: Part, block: Block) -> None:
    for line in block.lines:
        master, count, node, step, *outer = integers(line, [0, 1, 1, 1, 1, 0, 0, 1, 0, 0])
        old = part.elements.get(master)
        if old is None:
            raise MeshError(f"{line.where}: there is no element {master} before this line: give it first")
        rows, row_node, row_step, layers, layer_node, layer_step = outer
        limited(count * rows * layers, line)
        numbers = []
        for c in range(layers):
            for b in range(rows):
                for a in range(count):
                    shift = a * node + b * row_node + c * layer_node
                    number = master + a * step + b * row_step + c * layer_step
                    numbers.append(number)
                    part.elements[number] = _shifted(old, shift)
        _into(part.element_sets, block, "ELSET", numbers)


def _shifted(element: Element, shift: int) -> Element:
    nodes: list[Label] = [node + shift if isinstance(node, int) else node for node in element.nodes]
    return Element(element.name, element.type, nodes)


def _copy_elements(part: Part, block: Block) -> None:
    _only(block, "ELEMENT SHIFT", "OLD SET", "SHIFT NODES", "NEW SET")
    here = Line([], block.where, False)
    change, shift = (whole(block.options.get(key, ""), here) for key in ("ELEMENT SHIFT", "SHIFT NODES"))
    old = numbers_in(part.element_sets, block.options.get("OLD SET", ""), block)
    part.elements.update({n + change: _shifted(part.elements[n], shift) for n in old if n in part.elements})
    _into(part.element_sets, block, "NEW SET", [n + change for n in old])


def _node_set(part: Part, block: Block) -> None:
    _set(part.node_sets, block, "NSET")


def _element_set(part: Part, block: Block) -> None:
    _set(part.element_sets, block, "ELSET")


def _set(sets: dict[str, Members], block: Block, key: str) -> None:
    name = block.options.get(key, "")
    if not name:
        raise MeshError(f"{block} has no name: add {key}=")
    found = members_of(sets, name)
    instance = block.options.get("INSTANCE", "")
    if key == "NSET" and block.options.get("ELSET"):
        found.of_elements.append(block.options["ELSET"])
    for line in block.lines:
        numbers: range | list[int]
        if "GENERATE" in block.options:
            first, last, step = integers(line, [0, -1, 1])
            numbers = range(first, max(first, last) + 1, max(1, abs(step)))
        else:
            numbers = [whole(text, line) for text in line.fields if text.isdecimal()]
            found.others += [(instance, text) for text in line.fields if text and not text.isdecimal()]
        if instance:
            found.of_instance.append((instance, numbers))
        else:
            found.numbers.append(numbers)


def _only(block: Block, *known: str) -> None:
    spare = next((key for key in block.options if key not in known), None)
    if spare is not None:
        raise MeshError(f"{block}, {spare} is not read: write the nodes or elements out")


_ACTIONS: dict[str, Callable[[Part, Block], None]] = {
    "SYSTEM": _system,
    "NODE": _nodes,
    "NGEN": _node_lines,
    "NFILL": _fill,
    "NCOPY": _copy_nodes,
    "ELEMENT": _elements,
    "ELGEN": _element_rows,
    "ELCOPY": _copy_elements,
    "NSET": _node_set,
    "ELSET": _element_set,
}
