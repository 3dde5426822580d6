"""When an explicit flight is stopped because its energy rose out of nothing.

Symbols: E kinetic and stored energy, W work done and D energy dissipated since the start; h step length, a the
acceleration; r = h/h_s, with h_s the longest stable step, so that h ω ≤ 2r for each mode.

The energy of a sound leapfrog is not constant. That of a linear system swings around the one that it keeps,

    H = E − h²/8 a·M a,       H ≤ E ≤ H/(1 − r²),

and H jumps where a cable goes taut or slack. At speed v along it, before or after, and at the depth δ < h v at the one
instant, it jumps by ½ ω² δ (h v − δ) per unit mass, at most r² of the kinetic energy on the slack side: a bounce of a
mass may leave up to 1/(1 − r²) of its energy. So with `SPARE` for all else the flight is unsound if H has risen by more
than c = SPARE + r²/(1 − r²), or E by more than (1 + c)/(1 − r²) − 1, of the energy at the start and all work since.

H is blind to a linear mode with h ω > 2, of which it keeps the growing and the decaying part apart; E is not, and such
a mode grows by a factor in each step. Hence a rise must last: at the ends of `CHUNKS` chunks in a row, or of one where
it is `SURE` times that energy. No rise counts below the energy of a strain of `ROUND_OFF` in all cables.
"""

from __future__ import annotations

from typing import NamedTuple

CHUNKS = 4  # after which a rise is believed
SPARE = 0.1
SURE = 100.0
ROUND_OFF = 1e-11  # strain
LARGEST = 0.9  # r that is allowed for


class Guard(NamedTuple):
    """What is known of the energy since the start, J.

    start : E at the start; work : W − D; moved : sum of |W| of all chunks; rise : of E, in the last chunk
    chunks : ends of chunks in a row at which a rise was too large
    """

    start: float
    work: float = 0.0
    moved: float = 0.0
    rise: float = 0.0
    chunks: float = 0.0

    def after(
        self, energy: float, ripple: float, work: float, dissipated: float, *, share: float, floor: float
    ) -> Guard:
        """The guard after a chunk with E now, h²/8 a·M a, and its W and D; share is r, floor in J."""
        gained = self.work + work - max(dissipated, 0.0)  # no damper gives energy
        moved = self.moved + abs(work)
        rise = energy - self.start - gained
        square = min(share, LARGEST) ** 2
        kept = SPARE + square / (1.0 - square)
        scale = max(abs(self.start) + moved, floor)
        unsound = rise - ripple > kept * scale or rise > ((1.0 + kept) / (1.0 - square) - 1.0) * scale
        chunks = self.chunks + (CHUNKS if rise > SURE * scale else 1) if unsound else 0.0
        return Guard(self.start, gained, moved, rise, chunks)

    @property
    def stops(self) -> bool:
        """Whether the rise has lasted."""
        return self.chunks >= CHUNKS
