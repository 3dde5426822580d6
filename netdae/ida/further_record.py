"""The record of all that acts beside cables, damping and loads, for `ida.further`: made of a system's forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from netdae._arrays import IntArray
from netdae.explicit.forces import KernelForces
from netdae.forces.air import AirOnCables
from netdae.forces.brake import Brake, EndStop
from netdae.forces.cables import Cables
from netdae.forces.drag import DragOnBodies
from netdae.forces.drawcord import SlidingCord
from netdae.forces.free_molecular import MolecularDrag
from netdae.forces.loads import UniformLoad
from netdae.forces.motor import Motor
from netdae.forces.orbit import OrbitForce
from netdae.forces.protocol import Force
from netdae.forces.rayleigh import MassDamping, StiffnessDamping
from netdae.forces.reel import Reeled
from netdae.forces.solar import LightOnCables
from netdae.ida.addressed import Addressed
from netdae.ida.asked import Asked
from netdae.ida.further import FURTHER
from netdae.ida.lines import is_line, line_of
from netdae.kernels.strings import motors_of, ranks_of, strings_of, tangents_of
from netdae.kernels.surfaces import skins_of
from netdae.signals import Signal
from netdae.system import System

SURFACES = AirOnCables | MolecularDrag | LightOnCables | DragOnBodies
_FURTHER = Reeled | Brake | EndStop | Motor | SlidingCord | OrbitForce | SURFACES
_KNOWN = (
    *(Cables, Reeled, Brake, EndStop, Motor, SlidingCord),
    *(StiffnessDamping, MassDamping, OrbitForce),
)


class FurtherRecord:
    """The record of a system; `links` is the number of its blocks beside the diagonal.

    forces : those of the system for the kernels; others : those that Python is asked for
    held : puts restrained axes where they belong at a time, see `ida.asked`
    """

    def __init__(
        self,
        system: System,
        forces: KernelForces,
        others: Sequence[Force],
        held: Callable[[float], None] | None,
    ) -> None:
        # compiled at its first import, which takes as long as all the rest
        from netdae.ida.further_functions import FUNCTIONS

        record = Addressed(FURTHER)
        record.set(**{name: function.address for name, function in FUNCTIONS.items()})
        record.place(peak=np.zeros(1))
        _place_reels(record, forces)
        _place_drums(record, system, forces)
        _place_cords(record, system)
        self.asked = Asked(record, system, others, held)
        _place_links(record, system)
        self._signals = _place_around(record, [each for each in system.forces if _is_known(each)])
        self._record = record
        self.address, self.links = record.address, int(record["links"])

    def go_on(self, part: System, begin: float, end: float) -> None:
        """Signals as they are from `begin` to `end`, where they are linear in time."""
        self.asked.go_on(part)
        arrays = self._record.arrays
        arrays["signal_since"][0] = begin
        for s, signal in enumerate(self._signals):
            arrays["signal_start"][s], arrays["signal_rate"][s] = line_of(signal, begin, end)


def others_of(system: System) -> list[Force]:
    """Forces of a system that compiled code does not know."""
    return [each for each in system.forces if not _is_known(each)]


def _is_known(force: Force) -> bool:
    if isinstance(force, UniformLoad | SURFACES):
        return is_line(force.signal)
    return type(force) in _KNOWN


def further_record_of(
    system: System, forces: KernelForces, held: Callable[[float], None] | None
) -> FurtherRecord | None:
    """The record of a system; None where nothing acts but cables, damping and loads."""
    others = others_of(system)
    if system.reels or others or held or any(isinstance(each, _FURTHER) for each in system.forces):
        return FurtherRecord(system, forces, others, held)
    return None


def _place_reels(record: Addressed, forces: KernelForces) -> None:
    reels, m = forces.reels, len(forces.reels.L)
    record.set(cables=m)
    record.place(
        **{f"reel_{name}": getattr(reels, name) for name in reels._fields if name != "ends"},
        reel_ends=reels.ends.astype(np.int64),
        reel_x=np.zeros((m, 3, 3)),
        reel_v=np.zeros((m, 3, 3)),
        reel_f=np.zeros((m, 3, 3)),
        reel_now=np.zeros(m),
        reel_taut=np.zeros(m, dtype=np.int64),
        reel_count=np.zeros(1, dtype=np.int64),
        reel_K=np.zeros((m, 3, 3, 3, 3)),
        reel_C=np.zeros((m, 3, 3, 3, 3)),
    )


def _place_drums(record: Addressed, system: System, forces: KernelForces) -> None:
    brakes, stops = forces.drums.brakes, forces.drums.stops
    motors = motors_of([each for each in system.forces if isinstance(each, Motor)])
    drums = np.unique(np.concatenate((brakes.entry, stops.entry, motors.entry))).astype(np.int64)
    for kind, numbers in (("brake", brakes), ("stop", stops), ("motor", motors)):
        record.place(**{f"{kind}_{name}": getattr(numbers, name) for name in numbers._fields})
    record.set(brakes=len(brakes.entry), stops=len(stops.entry), motors=len(motors.entry), drums=len(drums))
    record.place(drum_entry=drums, drum_D=np.zeros(len(drums)))


def _place_cords(record: Addressed, system: System) -> None:
    strings = strings_of([each for each in system.forces if isinstance(each, SlidingCord)])
    tangents, r = tangents_of(strings), int(ranks_of(strings).sum())
    n, k, segments = len(system.mass), len(strings.entry), int(strings.first[-1])
    record.set(n=n, cords=len(strings.L), cord_nodes=k, segments=segments, rows=len(tangents.left), ranks=r)
    record.place(
        **{f"cord_{name}": getattr(strings, name) for name in strings._fields},
        cord_x=np.zeros((k, 3)),
        cord_v=np.zeros((k, 3)),
        cord_f=np.zeros((k, 3)),
        cord_tension=np.zeros(segments),
        rank=tangents.rank,
        rank_begin=tangents.begin,
        chain=tangents.chain,
        left=tangents.left,
        by_x=tangents.by_x,
        by_v=tangents.by_v,
        dyad_cord=np.zeros(r, dtype=np.int64),
        dyad_row=np.zeros(r, dtype=np.int64),
        dyad_count=np.zeros(1, dtype=np.int64),
        Z=np.zeros((3 * n, r)),
        W=np.zeros((r, r)),
        swaps=np.zeros(r, dtype=np.int64),
        amounts=np.zeros(r),
    )


def _place_around(record: Addressed, forces: Sequence[Force]) -> list[Signal]:
    """Orbits, and what air and light meet; the signals that those depend on."""
    surfaces = [each for each in forces if isinstance(each, SURFACES)]
    skins, bodies = skins_of(surfaces)
    orbits = [each for each in forces if isinstance(each, OrbitForce)]
    nodes = [each.nodes[:, 0] for each in orbits]
    record.set(
        skins=len(skins.L), bodies=len(bodies.entry), tides=sum(map(len, nodes)), signals=len(surfaces)
    )
    signals = np.zeros((len(surfaces), 3))
    record.place(
        **{f"skin_{name}": getattr(skins, name) for name in skins._fields},
        **{f"body_{name}": getattr(bodies, name) for name in bodies._fields},
        tide_entry=3 * np.concatenate([np.zeros(0, dtype=np.int64), *nodes]),
        tide_mass=np.concatenate([np.zeros(0), *(each.mass for each in orbits)]),
        tide_mean_motion=np.repeat(
            [float(each.mean_motion) for each in orbits], [len(each) for each in nodes]
        ),
        signal_start=signals,
        signal_rate=signals,
        signal_values=signals,
        signal_since=np.zeros(1),
    )
    return [each.signal for each in surfaces]


def _place_links(record: Addressed, system: System) -> None:
    """The blocks between the nodes of reeled cables and along cords, each pair once, and all nodes concerned."""
    pattern, arrays = system.pattern, record.arrays
    ends = arrays["reel_ends"] // 3
    links = [each.links for each in system.forces if isinstance(each, SlidingCord)]
    chain = np.concatenate([np.zeros((0, 2), dtype=np.int64), *links])
    corners = _blocks_of(pattern.rows, pattern.columns, ends[:, [[0, 1], [0, 2], [1, 2]]])
    of_chain = _blocks_of(pattern.rows, pattern.columns, chain)
    asked = arrays["asked_block"]
    beside = asked[pattern.rows[asked] != pattern.columns[asked]]
    blocks = np.unique(np.concatenate((corners.ravel(), of_chain, beside)))
    entries = [arrays[name] for name in ("reel_ends", "drum_entry", "cord_entry")]
    nodes = np.unique(np.concatenate([each.ravel() // 3 for each in entries] + [pattern.rows[asked]]))
    record.set(links=len(blocks), nodes=len(nodes))
    record.place(
        joined=nodes,
        link_low=pattern.rows[blocks],
        link_high=pattern.columns[blocks],
        link_block=blocks,
        corners=corners,
        chain_block=of_chain,
    )


def _blocks_of(rows: IntArray, columns: IntArray, pairs: IntArray) -> IntArray:
    """The block of each of some pairs of nodes (..., 2) in a pattern with `rows` and `columns` (b,), (...)."""
    n = int(columns.max(initial=0)) + 1
    return np.searchsorted(columns * n + rows, pairs.max(axis=-1) * n + pairs.min(axis=-1)).astype(np.int64)
