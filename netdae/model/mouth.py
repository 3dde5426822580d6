"""The mouth of a net: the closed loop of nodes at its rim, and the area that it spans.

Symbols: r_k positions along the loop (k, 3), m; the loop closes from its last node to its first.
"""

from __future__ import annotations

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.model.net import CableNet


def vector_area(points: FloatArray) -> float:
    """Size of the vector area of a closed loop, ½|Σ r_k × r_{k+1}|, m².

    For a plane loop this is its area, whatever its tilt; for a warped one, the largest area of its projections.
    """
    r = points - points[0]  # the origin drops out; the closing term with it
    products = r[:-1].T @ r[1:]  # (3, 3): Σ r_k ⊗ r_{k+1}
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = products.tolist()
    return 0.5 * ((yz - zy) ** 2 + (zx - xz) ** 2 + (xy - yx) ** 2) ** 0.5


def mouth_of(net: CableNet, mouth: str) -> IntArray:
    """Nodes of the closed loop through the node group `mouth`, in order.

    Border cables are those of the cable group with the same name where there is one, else the cables with
    both ends in the group. A cable group alone, without a node group of that name, will do.
    Raises InputError if the group is unknown or is not one closed loop.
    """
    cables = net.cables
    if mouth in net.cable_groups and mouth != "all":
        cables = cables[net.cables_of(mouth)]
        if mouth not in net.node_groups:
            return loop_of(cables, np.unique(cables), name=mouth)
    return loop_of(cables, net.nodes_of(mouth), name=mouth)


def loop_of(cables: IntArray, members: IntArray, *, name: str = "mouth") -> IntArray:
    """Order `members` along the closed loop of cables that passes each of them once.

    cables : (m, 2); those with an end outside `members` do not count
    members : (k,) node indices
    name : what messages call the group

    Where more than two cables meet at a node, for instance by a chord across a corner mesh, a cable is left
    out if the nodes' other cables leave it no place in such a loop. The loop starts at its smallest node and
    goes towards the smaller of its neighbours. Raises InputError if there is not exactly one loop.
    """
    members = np.unique(members)
    if len(members) < 3:
        count = "1 node" if len(members) == 1 else f"{len(members)} nodes"
        raise InputError(f"the mouth group {name!r} has {count}, but a closed loop needs at least three")
    inside = np.isin(cables, members).all(axis=1)
    neighbours: dict[int, set[int]] = {int(node): set() for node in members}
    for i, j in cables[inside].tolist():
        neighbours[i].add(j)
        neighbours[j].add(i)
    for node, others in neighbours.items():
        if len(others) < 2:
            found = "no cable" if not others else "only one cable"
            raise InputError(
                f"the mouth group {name!r} is not a closed loop: node {node} has {found} to another node of the group; "
                "choose a group whose cables form one ring"
            )
    _leave_chords_out(neighbours)
    for node, others in neighbours.items():
        if len(others) != 2:
            raise InputError(
                f"the mouth group {name!r} is not a single loop: node {node} has {len(others)} cables in the group, to "
                f"nodes {', '.join(map(str, sorted(others)))}; "
                "remove inner nodes from the group, or define a cable group for the border"
            )
    first = int(members[0])
    loop, here = [first], min(neighbours[first])
    while here != first:
        before, (one, other) = loop[-1], neighbours[here]
        loop.append(here)
        here = other if one == before else one
    if len(loop) < len(members):
        outside = int(np.setdiff1d(members, loop)[0])
        raise InputError(
            f"the mouth group {name!r} forms separate loops: node {outside} is not on the loop of {len(loop)} nodes "
            f"through node {first}; choose a group that is one loop"
        )
    return np.array(loop, dtype=np.int64)


def _leave_chords_out(neighbours: dict[int, set[int]]) -> None:
    """Remove cables that no loop through all nodes can use, as long as each removal is forced.

    A node's last two cables are used. A used-up node drops its other cables; so do the two ends of a path of
    used cables that would close before all nodes are on it.
    """
    other_end = {node: node for node in neighbours}  # of the path of used cables that ends here
    used: dict[int, set[int]] = {node: set() for node in neighbours}
    length = dict.fromkeys(neighbours, 1)
    pending = [node for node, others in neighbours.items() if len(others) == 2]

    def drop(i: int, j: int) -> None:
        if j in neighbours[i] and j not in used[i] and min(len(neighbours[i]), len(neighbours[j])) > 2:
            neighbours[i].discard(j)
            neighbours[j].discard(i)
            pending.extend(node for node in (i, j) if len(neighbours[node]) == 2)

    while pending:
        i = pending.pop()
        for j in tuple(neighbours[i] - used[i]):
            if len(used[j]) == 2 or other_end[i] == j:
                continue  # a contradiction or the closing cable: left to the checks that follow
            used[i].add(j)
            used[j].add(i)
            a, b = other_end[i], other_end[j]
            other_end[a], other_end[b] = b, a
            length[a] = length[b] = length[a] + length[b]
            for node in (i, j):
                if len(used[node]) == 2:
                    for spare in tuple(neighbours[node] - used[node]):
                        drop(node, spare)
            if length[a] < len(neighbours):
                drop(a, b)


def corners_of(net: CableNet, loop: IntArray, corners: str) -> IntArray:
    """Nodes of the group `corners` in the order in which the loop through the mouth meets them.

    A corner off the loop, for instance a bullet on a thread of its own, takes the place of the loop's node
    that is the fewest cables away. Raises InputError if the order stays ambiguous.
    """
    members = net.nodes_of(corners)
    unset = len(loop)
    place = np.full(net.node_count, unset)
    place[loop] = np.arange(len(loop))
    ends = np.concatenate([net.cables, net.cables[:, ::-1]])
    while (place[members] == unset).any():
        reached = ends[(place[ends[:, 0]] < unset) & (place[ends[:, 1]] == unset)]
        if len(reached) == 0:
            node = members[place[members] == unset][0]
            raise InputError(
                f"the corner group {corners!r} contains node {node}, which no cables connect to the mouth; "
                "choose other corners"
            )
        np.minimum.at(place, reached[:, 1], place[reached[:, 0]])
    order = np.argsort(place[members], kind="stable")
    result = members[order]
    same = np.flatnonzero(np.diff(place[result]) == 0)
    if len(same):
        i, j = result[same[0]], result[same[0] + 1]
        raise InputError(
            f"the corner group {corners!r} contains nodes {i} and {j}, which attach to the mouth at the same node, so "
            "their order around it is ambiguous; choose other corners"
        )
    return result
