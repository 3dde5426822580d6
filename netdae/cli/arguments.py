"""Arguments of the command line, taken literally: no number is rounded, and an empty name is not a path."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter, Token


def whole_number(kind: Any, tokens: Sequence[Token]) -> int:
    """The number that an argument states; raises ValueError for anything else, also for 4.9 and 0x4."""
    text = tokens[0].value
    if not re.fullmatch(r"[+-]?[0-9]+", text):
        raise ValueError(f'"{text}", expected a whole number')
    return int(text)


def place(kind: Any, tokens: Sequence[Token]) -> Path:
    """The file or folder that an argument names; raises ValueError for an empty name."""
    text = tokens[0].value
    if not text.strip():
        raise ValueError(f'"{text}" is empty, expected a name, or . for this folder')
    return Path(text)


WholeNumber = Annotated[int, Parameter(converter=whole_number)]
"""An int that takes digits only."""
