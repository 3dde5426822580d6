"""Which source files a module depends on: its own, and those of all that it imports from the same package."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([\w.]+))", re.MULTILINE
)
_NAME = re.compile(r"(\w+)(?:\s+as\s+\w+)?\s*(?:,|$)")


class Sources:
    """Sources of the package in a folder; a file is read once.

    The package's own __init__.py, which re-exports everything for users, is not a source of its modules.
    """

    def __init__(self, folder: str) -> None:
        self._root = folder.rstrip(os.sep)
        self._name = os.path.basename(self._root)
        self._imports: dict[str, tuple[str, ...]] = {}
        self._closures: dict[str, frozenset[str]] = {}

    def closure_of(self, path: str) -> frozenset[str]:
        """The file at a path, and all files of the package that it imports, directly or not, also inside functions."""
        if path not in self._closures:
            seen: set[str] = set()
            left = [path]
            while left:
                if (one := left.pop()) not in seen:
                    seen.add(one)
                    left += self._imported_by(one)
            self._closures[path] = frozenset(seen)
        return self._closures[path]

    def _imported_by(self, path: str) -> tuple[str, ...]:
        if path not in self._imports:
            try:
                with open(path, encoding="utf-8") as file:
                    text = file.read()
            except OSError:  # deleted meanwhile
                text = ""
            self._imports[path] = tuple(self._files_in(text))
        return self._imports[path]

    def _files_in(self, text: str) -> Iterator[str]:
        for module, members, plain in _IMPORT.findall(text):
            names = [module or plain]
            names += (
                [f"{module}.{name}" for name in _NAME.findall(members.strip("() \t\n"))] if module else []
            )
            for name in names:
                parts = name.split(".")
                place = os.path.join(self._root, *parts[parts[0] == self._name :]).rstrip(os.sep)
                inside = os.path.join(place, "__init__.py")
                for file in (f"{place}.py", *([inside] if place != self._root else [])):
                    if os.path.isfile(file):
                        yield file
