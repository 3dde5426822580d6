"""Groups that a scenario names."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches

from netdae._arrays import IntArray
from netdae.errors import InputError


def check_group(groups: Mapping[str, IntArray], name: str, kind: str) -> None:
    """Raise InputError with the nearest name where there is no `kind` ("node" or "cable") group of this name."""
    if name not in groups:
        near = get_close_matches(name, groups, n=1)
        hint = f"did you mean {near[0]!r}? The" if near else "the"
        raise InputError(f"there is no {kind} group {name!r}: {hint} net has {', '.join(sorted(groups))}")
