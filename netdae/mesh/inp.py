"""Element sets of Abaqus .inp files.

meshio assigns the set of the k-th *ELEMENT line that names one to the k-th block, and drops an earlier
*NODE, *NSET or *ELSET of the same name. The first is corrected here, the second is rejected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from netdae.core.arrays import IntArray
from netdae.core.errors import MeshError
from netdae.mesh.findings import FileNumbers

Keywords = Sequence[tuple[str, Mapping[str, str]]]


def keywords_of(text: str) -> Keywords:
    """Keyword and parameters of each keyword line; raises MeshError where meshio would lose a part."""
    keywords = [_keyword_of(line) for line in text.splitlines() if line.startswith("*") and line[1:2] != "*"]
    _refuse_repeated(keywords)
    return keywords


def element_sets_of(keywords: Keywords, sizes: Sequence[int], sets: Mapping[str, Any]) -> dict[str, IntArray]:
    """Name to elements, from the keywords, the sizes of meshio's cell blocks and its cell sets."""
    starts = np.cumsum([0, *sizes])
    elements = [given for word, given in keywords if word == "ELEMENT"]
    whole: dict[str, list[IntArray]] = {}
    for k, given in enumerate(elements):
        if given.get("ELSET"):
            whole.setdefault(given["ELSET"], []).append(np.arange(starts[k], starts[k + 1]))
    result = {name: np.concatenate(members) for name, members in whole.items()}
    for name, blocks in sets.items():
        if name not in result:
            result[name] = _set_of_blocks(name, blocks, starts)
    return result


def numbers_of(text: str) -> FileNumbers:
    """Numbers of the nodes and elements; raises ValueError where they are not numbers."""
    nodes: list[int] = []
    elements: list[tuple[int, list[int]]] = []
    section, pending = "", []
    for line in text.splitlines():
        if line.startswith("*"):
            section = section if line.startswith("**") else _keyword_of(line)[0]
        elif section == "NODE" and line.strip():
            nodes.append(int(line.split(",")[0]))
        elif section == "ELEMENT" and line.strip():
            pending += [int(field) for field in line.split(",") if field.strip()]
            if not line.rstrip().endswith(","):  # else the element continues in the next line
                elements.append((pending[0], pending[1:]))
                pending = []
    return FileNumbers(nodes, elements)


def _keyword_of(line: str) -> tuple[str, dict[str, str]]:
    word, *parts = line[1:].split(",")
    pairs = (part.partition("=") for part in parts)
    return word.strip().upper(), {key.strip().upper(): value.strip() for key, _, value in pairs}


def _refuse_repeated(keywords: Keywords) -> None:
    seen = set()
    for word, given in keywords:
        if word == "INCLUDE":
            raise MeshError("*INCLUDE is not followed: put the mesh in one file")
        if word not in ("NODE", "NSET", "ELSET"):
            continue
        title = "*NODE" if word == "NODE" else f"*{word} {given.get(word, '')}"
        if title in seen:
            raise MeshError(f"{title} is given more than once: put its entries under one keyword")
        seen.add(title)
    for word, given in keywords:
        name = given.get("ELSET", "")
        if word == "ELEMENT" and f"*ELSET {name}" in seen:
            raise MeshError(f"the set {name} is given by *ELEMENT and by *ELSET: use two names")


def _set_of_blocks(name: str, blocks: Sequence[Any], starts: IntArray) -> IntArray:
    if len(blocks) != len(starts) - 1 or any(np.ndim(block) != 1 for block in blocks):
        raise MeshError(f"the set {name} is made of other sets: list its elements by number")
    members = [start + np.asarray(block, np.int64) for start, block in zip(starts, blocks, strict=False)]
    return np.concatenate(members)
