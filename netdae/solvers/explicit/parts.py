"""What the compiled explicit step reads and writes: bodies, forces, restrained axes, and its workspace.

Arrays are flat over the net, (3n,), node i at 3i.
"""

from __future__ import annotations

from typing import NamedTuple

from netdae.core.arrays import Flags, FloatArray, Reals, Wholes


class Bodies(NamedTuple):
    """What moves."""

    mass: Reals  # (3n,), kg
    share: Reals  # (3n,), 1/mass, zero on restrained axes
    in_space: Flags  # (n,), False for nodes of reels
    always: Flags  # (n,), nodes on which a force may act that is not sifted, or that are restrained
    whole: bool  # whether forces act on all nodes at once
    shortest: float  # m, of the cables
    pose: int  # address of the attitude of a target that turns, or 0
    spin: int  # its entries in x and v begin here
    free: bool  # whether it turns freely
    radius: float  # m, of its farthest point


class Acting(NamedTuple):
    """What acts: the table's forces, and those that are taken at the end of the step."""

    rows: int  # address of the table's
    drums: int  # address of the Drums
    slow_rows: int  # address of those of the forces that are held for some steps
    slow: Reals  # (3n,), room for their sum, or (0,) where there are none
    slow_x: Reals  # (3n,) or (0,), room for places and velocities in their middle
    slow_v: Reals
    ahead: Reals  # (3n,), room for velocities at the end of the step where a force needs them, or (0,)
    in_python: bool  # whether any force is written in Python
    contacts: int  # address of the Contacts, or 0
    rubs: bool  # whether friction bounds the step


class Held(NamedTuple):
    """Restrained axes: entries of x, their anchors, and which component of which motion drives them.

    x, R, speed : their places and reactions before, and their velocities now
    """

    entry: Wholes  # (c,)
    anchor: Reals  # (c,), m
    motion: Wholes  # (c,)
    x: Reals  # (c,), m
    R: Reals  # (c,), N
    speed: Reals  # (c,), m/s


class Room(NamedTuple):
    """Workspace of a run of steps.

    begin, end : of the spans of active nodes, of which there are counts[0]; counts[1] steps have passed since the other
        nodes were moved, and counts[2] since a free target was turned
    reach : see `active`
    """

    f: Reals  # (3n,), N
    kick: Reals  # (3n,), h/mass
    viscous: Reals  # (3n,), N, of Rayleigh damping
    now: Reals  # (3n,), m/s, the velocity at which it is taken
    moves: Flags  # (n,), whether a node is active
    begin: Wholes  # (n,)
    end: Wholes  # (n,)
    counts: Wholes  # (3,)
    reach: Reals  # (5,)
    drift: Reals  # (3n,), m/s, the mean velocity u at each node
    sums: Reals  # of the forces, see `forces.loops`
    gained: Reals  # (8,), what the balance has gained: energy dissipated and work in J, N s (3,), N m s (3,)
    outside: Reals  # (6,), external force and torque at this instant, N and N m


class Tally(NamedTuple):
    """The result of a run of steps."""

    steps: int  # fewer than requested where a limit was passed, a reel wound in too far, or a force in Python failed
    dissipated: float  # J
    work: float  # J
    impulse: FloatArray  # (6,), N s and N m s
    peak: float  # tension, N
    peak_step: int
    strain: float  # the largest E11
    rate: float  # the largest rate of friction, 1/s
    crest: float  # N, the largest tension found inside of steps, see `discrete_gradient`
    crest_at: float  # steps until then


LOST, WORK, IMPULSE = 0, 1, 2
"""Places in what the balance has gained, and in the powers of an instant: W, W, N (3,), N m (3,)."""
POWERS = 8
