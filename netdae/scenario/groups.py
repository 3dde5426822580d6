"""Groups that a scenario names."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches

from netdae.core.arrays import IntArray
from netdae.core.errors import InputError
from netdae.model.net import CableNet


def check_group(groups: Mapping[str, IntArray], name: str, kind: str) -> None:
    """Raise InputError with the nearest name where there is no `kind` ("node" or "cable") group of this name."""
    if name not in groups:
        near = get_close_matches(name, groups, n=1)
        hint = f"did you mean {near[0]!r}? The" if near else "the"
        raise InputError(f"there is no {kind} group {name!r}: {hint} net has {', '.join(sorted(groups))}")


def check_nodes(net: CableNet, group: str, *, alone: bool) -> None:
    """Raise InputError for an unknown node group, and for "all" where it has more in it than the net.

    alone : whether the net flies without tether and drums
    """
    check_group(net.node_groups, group, "node")
    if group == "all" and not alone:
        raise InputError(
            "group 'all' has the tether, the chaser and all drums in it too: name a group of the net alone"
        )
