"""Files that a scenario names, meshes and tables, and its text with their full names, for a copy elsewhere."""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

# the first key `file` of a line, outside of comments, with its value in quotes
_FILE = re.compile(r"""(?m)^((?:[^#\n]*?[{,])?[ \t]*file[ \t]*=[ \t]*)("(?:[^"\\\n]|\\.)*"|'[^'\n]*')""")


def names_of(data: Any) -> Iterator[str]:
    """Names of files in the data of a scenario, as they stand there."""
    if isinstance(data, dict):
        for key, value in data.items():
            if key == "file" and isinstance(value, str):
                yield value
            else:
                yield from names_of(value)
    elif isinstance(data, list):
        for each in data:
            yield from names_of(each)


def with_full_names(text: bytes, folder: Path) -> bytes:
    """The text of a scenario in `folder` with the full names of its files; all else, also comments, is kept.

    A text that is written too oddly for that is handed back with a first line that says what its names are
    relative to.
    """
    given = text.decode("utf-8-sig")
    data = tomllib.loads(given)
    if all(_full(name, folder) == name for name in names_of(data)):
        return text

    def placed(found: re.Match[str]) -> str:
        name = tomllib.loads(f"name = {found[2]}")["name"]
        # TOML takes what JSON writes
        return f"{found[1]}{json.dumps(_full(name, folder), ensure_ascii=False)}"

    result = _FILE.sub(placed, given)
    if _is_same(result, _placed_data(data, folder)):
        return result.encode()
    return f"# names of files are relative to {_full('.', folder)}\n{given}".encode()


def _full(name: str, folder: Path) -> str:
    return name if Path(name).is_absolute() else Path(os.path.abspath(folder / name)).as_posix()


def _placed_data(data: Any, folder: Path) -> Any:
    if isinstance(data, dict):
        return {
            key: _full(value, folder)
            if key == "file" and isinstance(value, str)
            else _placed_data(value, folder)
            for key, value in data.items()
        }
    return [_placed_data(each, folder) for each in data] if isinstance(data, list) else data


def _is_same(text: str, data: Any) -> bool:
    try:
        return bool(tomllib.loads(text) == data)
    except tomllib.TOMLDecodeError:
        return False
