"""Keyword blocks of an Abaqus or CalculiX input file: a keyword, its parameters and its data lines.

Keywords and parameters are upper case. Lines that begin with ** are comments, a keyword line that ends with a comma
goes on in the next line, and files named by *INCLUDE or by INPUT= are read in place.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from netdae.core.errors import MeshError

DEEPEST = 10
"""Files that include one another, at most."""

_FIELD = re.compile(r'\s*("[^"]*"|[^,]*)\s*(?:,|$)')
_PARAMETER = re.compile(r'[A-Za-z][^,="]*(=|,|$)')


class Line(NamedTuple):
    """Fields of a data line; `where` names it in messages; `goes_on`: it ends with a comma."""

    fields: list[str]
    where: str
    goes_on: bool


@dataclass(frozen=True)
class Block:
    """A keyword with its parameters, "" where one has no value, and its data lines."""

    keyword: str
    options: Mapping[str, str]
    where: str
    lines: list[Line] = field(default_factory=list)

    def __str__(self) -> str:
        return f"{self.where}: *{self.keyword}"


def blocks_of(text: str, folder: Path, *, file: str = "", depth: int = 0) -> Iterator[Block]:
    """Blocks of a file, in order; raises MeshError for an included file that is missing.

    folder : of the main file, to which the others are relative
    file : name of an included file, for messages
    """
    block: Block | None = None
    lines = [
        (k, line.strip())
        for k, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("**")
    ]
    place = 0
    while place < len(lines):
        number, line = lines[place]
        place += 1
        where = f"line {number} of {file}" if file else f"line {number}"
        if not line.startswith("*"):
            if block is not None:
                block.lines.append(Line(fields_of(line), where, line.endswith(",")))
            continue
        while line.endswith(",") and place < len(lines) and _PARAMETER.match(lines[place][1]):
            line += lines[place][1]
            place += 1
        if block is not None:
            yield block
        block = _block_of(line, where)
        name = block.options.get("INPUT", "")
        if block.keyword == "INCLUDE":
            yield from blocks_of(_text_of(name, folder, block, depth), folder, file=name, depth=depth + 1)
            block = None
        elif name and block.keyword in ("NODE", "ELEMENT", "NSET", "ELSET", "NGEN", "ELGEN"):
            block.lines.extend(_data_of(_text_of(name, folder, block, depth), name))
    if block is not None:
        yield block


def fields_of(line: str) -> list[str]:
    """Fields between the commas, stripped; a comma at the end adds none, and a quoted one keeps its quotes."""
    if '"' not in line:
        fields = [part.strip() for part in line.split(",")]
        return fields[:-1] if line.endswith(",") else fields
    fields, place = [], 0
    while place < len(line):
        found = _FIELD.match(line, place)
        if found is None or found.end() == place:
            fields.append(line[place:].strip())
            break
        fields.append(found[1].strip())
        place = found.end()
    return fields


def _block_of(line: str, where: str) -> Block:
    word, *parts = fields_of(line[1:]) or [""]
    options = {}
    for part in parts:
        key, _, value = part.partition("=")
        options[" ".join(key.upper().split())] = value.strip()
    return Block(" ".join(word.upper().split()), options, where)


def _text_of(name: str, folder: Path, block: Block, depth: int) -> str:
    name = name.strip('"')
    if not name:
        raise MeshError(f"{block} names no file: give it by INPUT=")
    if depth >= DEEPEST:
        raise MeshError(f"{block}: more than {DEEPEST} files include one another: end the circle")
    file = folder / name
    if not file.is_file():
        raise MeshError(f"{block}: there is no file {name} beside this one: put it there")
    return file.read_text(encoding="utf-8", errors="replace")


def _data_of(text: str, file: str) -> Iterator[Line]:
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if line and not line.startswith("*"):
            yield Line(fields_of(line), f"line {number} of {file}", line.endswith(","))
