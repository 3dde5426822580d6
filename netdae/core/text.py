"""Text of users' files as it is printed."""

from __future__ import annotations

import unicodedata

_HIDDEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}  # controls, marks of direction, halves of pairs, breaks


def as_text(text: str) -> str:
    """Text in which signs that a terminal would obey are shown by their codes, such as \\x1b for Escape."""
    return "".join(
        repr(sign)[1:-1] if unicodedata.category(sign) in _HIDDEN and sign != "\n" else sign for sign in text
    )
