"""Parts, instances and sets of an input file of Abaqus, brought together.

A scope is the instance that a label belongs to, by its key, "" outside of any.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.mesh.findings import many
from netdae.mesh.inp_blocks import Block
from netdae.mesh.inp_part import Element, Label, Members, Part, key_of
from netdae.mesh.inp_placing import Motion, shift_of, stay

NOT_READ = {
    "NMAP", "IMPERFECTION", "SYMMETRIC MODEL GENERATION", "IMPORT", "IMPORT NSET", "IMPORT ELSET",
    "MODEL CHANGE", "SUBSTRUCTURE PATH",
}  # fmt: skip
"""Keywords that place or remove something and are not read."""

JOINING = {
    "TIE", "MPC", "EQUATION", "COUPLING", "KINEMATIC COUPLING", "DISTRIBUTING COUPLING", "RIGID BODY",
    "EMBEDDED ELEMENT", "NETWORK MPC",
}  # fmt: skip
"""Keywords that hold nodes together, which a net does not do."""


@dataclass
class Instance:
    """A part at its place, with what its own blocks add."""

    name: str
    part: str
    motion: Motion
    own: Part = field(default_factory=Part)


@dataclass
class Deck:
    """What the blocks of a file have made so far."""

    root: Part = field(default_factory=Part)
    parts: dict[str, Part] = field(default_factory=dict)
    instances: dict[str, Instance] = field(default_factory=dict)
    joined_by: dict[str, int] = field(default_factory=dict)

    def add(self, blocks: Iterable[Block]) -> None:
        """Do what the blocks say; raises MeshError for keywords that place something and are not read."""
        within = self.root
        for block in blocks:
            word = block.keyword
            name = key_of(block.options.get("NAME", ""))
            if word == "PART":
                within = self.parts.setdefault(name, Part())
            elif word == "INSTANCE":
                within = self._instance(block, name)
            elif word in ("END PART", "END INSTANCE", "ASSEMBLY", "END ASSEMBLY"):
                within = self.root
            elif word in NOT_READ:
                raise MeshError(f"{block} is not read: write the nodes and elements out")
            elif word in JOINING:
                self.joined_by[word] = self.joined_by.get(word, 0) + 1
            else:
                within.take(block)

    def _instance(self, block: Block, name: str) -> Part:
        part = block.options.get("PART", "")
        if "LIBRARY" in block.options or not part:
            raise MeshError(f"{block} without PART is not read: give the part in this file")
        if name in self.instances:
            raise MeshError(f"{block}: there are two instances of the name {name}: rename one")
        shown = block.options.get("NAME", "").strip('"')
        instance = Instance(shown, key_of(part), shift_of(block))
        if instance.part not in self.parts:
            raise MeshError(f"{block}: there is no *PART, NAME={part} before it: add the part")
        self.instances[name] = instance
        return instance.own


@dataclass(frozen=True, eq=False)
class Assembled:
    """All nodes and elements of a deck.

    points : (p, 3), m
    node_labels, element_labels : what the file calls them
    elements : scope and element, (c,)
    """

    scopes: dict[str, Part]
    names: dict[str, str]
    points: FloatArray
    nodes: dict[tuple[str, int], int]
    cells: dict[tuple[str, int], int]
    elements: list[tuple[str, Element]]
    node_labels: list[Label]
    element_labels: list[Label]

    def node_of(self, scope: str, label: Label) -> int | None:
        """Index of the node of a label, None where there is none."""
        if isinstance(label, int):
            return self.nodes.get((scope, label))
        instance, _, number = label.rpartition(".")
        return self.nodes.get((key_of(instance), int(number))) if number.isdecimal() else None

    def sets(self, kind: str) -> tuple[dict[str, IntArray], list[str]]:
        """Groups of "node" or "element" by name, and what their author should know.

        A set of a part is the union over its instances; where there are several, INSTANCE.SET is each one's. A set of
        the assembly hides those of parts that share its name.
        """
        found: dict[str, tuple[str, set[int]]] = {}
        findings = []
        several = sum(1 for scope in self.scopes if scope) > 1
        hidden = {*_sets_of(self.scopes[""], kind)}
        for scope, part in self.scopes.items():
            for key, members in _sets_of(part, kind).items():
                indices, lost = self._resolve(scope, kind, key, frozenset())
                if lost:
                    findings.append(
                        f"the set {members.name} has {many(len(lost), 'member')} that the file does not have "
                        f"(first: {lost[0]})"
                    )
                if scope and several:
                    found[f"{scope}.{key}"] = (f"{self.names[scope]}.{members.name}", indices)
                if not scope or key not in hidden:
                    _, before = found.setdefault(key, (members.name, set()))
                    before |= indices
        return {name: np.array(sorted(at), dtype=np.int64) for name, at in found.values()}, findings

    def _resolve(
        self, scope: str, kind: str, key: str, above: frozenset[tuple[str, str, str]]
    ) -> tuple[set[int], list[str]]:
        indices: set[int] = set()
        lost: list[str] = []
        members = _sets_of(self.scopes[scope], kind).get(key)
        if members is None or (scope, kind, key) in above:
            return indices, [key]
        above |= {(scope, kind, key)}
        table = self.nodes if kind == "node" else self.cells
        own = [(scope, numbers) for numbers in members.numbers]
        for where, numbers in [*own, *((key_of(name), numbers) for name, numbers in members.of_instance)]:
            known = self.scopes[where] if where in self.scopes else Part()
            stock = known.nodes if kind == "node" else known.elements
            if isinstance(numbers, range) and len(numbers) > len(stock):
                # a generated set may leave numbers out
                indices.update(table[where, n] for n in stock if n in numbers)
                continue
            for n in numbers:
                if (where, n) in table:
                    indices.add(table[where, n])
                else:
                    lost.append(str(n))
        for instance, name in members.others:
            more, gone = self._named(key_of(instance) if instance else scope, kind, name, above)
            indices |= more
            lost += gone
        for name in members.of_elements:
            cells, gone = self._resolve(scope, "element", key_of(name), above)
            lost += gone
            for cell in cells:
                home, element = self.elements[cell]
                indices |= {at for label in element.nodes if (at := self.node_of(home, label)) is not None}
        return indices, lost

    def _named(
        self, scope: str, kind: str, name: str, above: frozenset[tuple[str, str, str]]
    ) -> tuple[set[int], list[str]]:
        """Members of a set or of a label INSTANCE.NUMBER, seen from a scope."""
        if scope in self.scopes and key_of(name) in _sets_of(self.scopes[scope], kind):
            return self._resolve(scope, kind, key_of(name), above)
        instance, dot, rest = name.strip('"').partition(".")
        home = key_of(instance)
        if dot and home in self.scopes:
            if not rest.isdecimal():
                return self._named(home, kind, rest, above)
            at = (self.nodes if kind == "node" else self.cells).get((home, int(rest)))
            return (set(), [name]) if at is None else ({at}, [])
        found: set[int] = set()
        holders = [each for each in self.scopes if each and key_of(name) in _sets_of(self.scopes[each], kind)]
        for holder in () if scope else holders:
            found |= self._resolve(holder, kind, key_of(name), above)[0]
        return found, [] if holders and not scope else [name]


def assembled(deck: Deck) -> Assembled:
    """Nodes and elements of all instances at their places; raises MeshError where no part is placed."""
    if deck.parts and not deck.instances and not deck.root.nodes:
        raise MeshError(
            f"the part {next(iter(deck.parts))} is placed nowhere, so there are no nodes: add an *INSTANCE of it"
        )
    scopes = {"": deck.root}
    motions = {"": stay()}
    for key, instance in deck.instances.items():
        scopes[key] = _merged(deck.parts[instance.part], instance.own)
        motions[key] = instance.motion
    names = {key: instance.name for key, instance in deck.instances.items()}
    nodes: dict[tuple[str, int], int] = {}
    cells: dict[tuple[str, int], int] = {}
    elements, points = [], [np.zeros((0, 3))]
    for scope, part in scopes.items():
        for number in part.nodes:
            nodes[scope, number] = len(nodes)
        if part.nodes:
            x = np.array(list(part.nodes.values()))
            points.append(motions[scope].of(x) if scope else x)
        for number, element in part.elements.items():
            cells[scope, number] = len(cells)
            elements.append((scope, element))

    def labels(table: dict[tuple[str, int], int]) -> list[Label]:
        return [f"{names[scope]}.{number}" if scope else number for scope, number in table]

    return Assembled(
        scopes, names, np.concatenate(points), nodes, cells, elements, labels(nodes), labels(cells)
    )


def _merged(part: Part, own: Part) -> Part:
    """A part and what an instance adds to it."""
    if not (own.nodes or own.elements or own.node_sets or own.element_sets):
        return part
    result = Part({**part.nodes, **own.nodes}, {**part.elements, **own.elements})
    for each in (part, own):
        for kind in ("node", "element"):
            for key, members in _sets_of(each, kind).items():
                whole = _sets_of(result, kind).setdefault(key, Members(members.name))
                whole.numbers += members.numbers
                whole.others += members.others
                whole.of_instance += members.of_instance
                whole.of_elements += members.of_elements
    return result


def _sets_of(part: Part, kind: str) -> dict[str, Members]:
    return part.node_sets if kind == "node" else part.element_sets
