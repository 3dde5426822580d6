"""A net in two CSV tables: NAME_nodes.csv and NAME_cables.csv.

nodes: x, y, z in m, and if wanted group, and name, by which cables call the node
cables: i, j, the nodes that a cable joins, by name or counted from 0, and if wanted group, rest_length, diameter and
other data of cables
A group column may hold several groups, with semicolons between them.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from netdae.core.arrays import IntArray
from netdae.core.errors import MeshError
from netdae.mesh.raw import NUMBERS, RawMesh

Rows = list[tuple[str, dict[str, str]]]


def read_csv_pair(file: Path) -> RawMesh:
    """Read the pair that a file is one of; raises MeshError."""
    for kind in ("_nodes", "_cables"):
        if file.stem.endswith(kind):
            stem = file.stem.removesuffix(kind)
            break
    else:
        raise MeshError("a net in CSV is a pair of tables: name them NAME_nodes.csv and NAME_cables.csv")
    nodes = _rows(file.with_name(f"{stem}_nodes.csv"), {"x", "y", "z"}, {"name", "group", "mass"})
    cables = _rows(file.with_name(f"{stem}_cables.csv"), {"i", "j"}, {"group", *NUMBERS})
    points = np.array([[_real(row, key, where) for key in "xyz"] for where, row in nodes]).reshape(-1, 3)
    names = [row.get("name") or str(k) for k, (_, row) in enumerate(nodes)]
    places = {name: k for k, name in enumerate(names)}
    if len(places) < len(names):
        twice = next(name for k, name in enumerate(names) if places[name] != k)
        raise MeshError(f"{stem}_nodes.csv: two nodes have the name {twice}: rename one")
    ends = [[_place(row, key, places, where) for key in "ij"] for where, row in cables]
    findings = []
    if any(row.get("mass") for _, row in nodes):
        findings.append("the column mass is not read: give the masses of node groups in [[masses]]")
    return RawMesh(
        points=points,
        cell_count=len(cables),
        ends=np.array(ends, dtype=np.int64).reshape(-1, 2),
        line_cell=np.arange(len(cables)),
        cell_data={
            name: np.array([_real(row, name, where) if row.get(name) else np.nan for where, row in cables])
            for name in NUMBERS
            if cables and name in cables[0][1]
        },
        point_sets=_groups(nodes),
        cell_sets=_groups(cables),
        findings=tuple(findings),
    )


def _rows(file: Path, needed: set[str], known: set[str]) -> Rows:
    if not file.is_file():
        raise MeshError(f"the other table, {file.name}, is not beside this one: put it there")
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream)
            rows = [(reader.line_num, [field.strip() for field in row]) for row in reader if any(row)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise MeshError(f"{file.name} is not a CSV table: {error}") from error
    head = [name.lower() for name in rows[0][1]] if rows else []
    lost, spare = needed - {*head}, {*head} - needed - known
    if lost or spare or len({*head}) < len(head):
        raise MeshError(
            f"{file.name}: the header is {','.join(head)[:80]!r}, expected {','.join(sorted(needed))} and, if wanted, "
            f"{', '.join(sorted(known))}"
        )
    for line, row in rows[1:]:
        if len(row) != len(head):
            raise MeshError(f"{file.name}: line {line} has {len(row)} fields, expected {len(head)}")
    return [(f"{file.name}: line {line}", dict(zip(head, row, strict=True))) for line, row in rows[1:]]


def _real(row: Mapping[str, str], key: str, where: str) -> float:
    try:
        return float(row[key])
    except ValueError:
        raise MeshError(f"{where}: {key} is {row[key][:40]!r}, expected a number") from None


def _place(row: Mapping[str, str], key: str, places: Mapping[str, int], where: str) -> int:
    found = places.get(row[key])
    if found is None:
        raise MeshError(
            f"{where}: {key} is {row[key][:40]!r}, but there is no node of this name: nodes without a name are counted "
            "from 0"
        )
    return found


def _groups(rows: Rows) -> dict[str, IntArray]:
    members: dict[str, list[int]] = {}
    for k, (_, row) in enumerate(rows):
        for name in filter(None, (each.strip() for each in row.get("group", "").split(";"))):
            members.setdefault(name, []).append(k)
    return {name: np.array(member, dtype=np.int64) for name, member in members.items()}
