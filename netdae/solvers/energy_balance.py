"""The energy balance of a flight: dissipated energy, external work and impulse by quadrature over internal steps.

Over one step of length h from (x₀, v₀) to (x₁, v₁), positions follow the cubic Hermite curve with the midpoint

    x½ = (x₀ + x₁)/2 + h (v₀ − v₁)/8,       v½ = 3 (x₁ − x₀)/(2h) − (v₀ + v₁)/4,

and powers are summed by Simpson's rule. For a constant load this is p·(x₁ − x₀) exactly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.model.restraints import Drive
from netdae.model.state import EnergyBalance, State
from netdae.solvers.stepper import NOTHING, Share
from netdae.system.system import System


class _Rates(NamedTuple):
    dissipated: float
    external: float
    wrench: FloatArray  # (2, 3), force and torque


class RunningBalance:
    """Accumulates the balance from internal step to internal step.

    `at(state)` gives the balance up to a state inside the running step and changes nothing.
    """

    def __init__(self, system: System, drive: Drive, start: State, *, peak: float | None = None) -> None:
        self._system = system
        self._drive = drive
        self._held = bool(drive.mask.any())
        self._last = start
        self._rates = self._rates_at(start.t, start.x, start.v)
        self._dissipated = start.balance.dissipated_energy
        self._work = start.balance.external_work
        self._impulse = np.array((start.balance.external_impulse, start.balance.external_angular_impulse))
        self._peak = system.peak_tension(start.x) if peak is None else peak

    def advance(self, state: State, share: Share | None = None) -> EnergyBalance:
        """Close the internal step that ends at `state` and return the balance up to it.

        share : of the step, where the integrator has summed it itself
        """
        if share is None:
            rates = self._rates_at(state.t, state.x, state.v)
            share = self._share(state, rates)
            self._rates = rates
        self._dissipated += share.dissipated_energy
        self._work += share.external_work
        self._impulse = self._impulse + np.stack((share.external_impulse, share.external_angular_impulse))
        self._peak = max(self._peak, share.peak_tension)
        self._last = state
        return self.balance()

    def balance(self) -> EnergyBalance:
        """EnergyBalance up to the last internal step."""
        return self._reported(NOTHING)

    def reported(self) -> EnergyBalance:
        """EnergyBalance up to the last internal step; its peak tension is reported only once."""
        balance = self.balance()
        self._peak = 0.0
        return balance

    def at(self, state: State, share: Share | None = None) -> EnergyBalance:
        """The balance up to a state inside the running step; the peak tension, of whole steps, is reported once."""
        if share is None:
            share = self._share(state, self._rates_at(state.t, state.x, state.v))
            share = share._replace(peak_tension=0.0)
        balance = self._reported(share)
        self._peak = 0.0
        return balance

    def enter(self, system: System, drive: Drive, state: State) -> FloatArray | None:
        """Start the phase `system` at `state`; a jump of velocity adds its work and its impulse (3,), also returned."""
        self._drive, self._held = drive, bool(drive.mask.any())
        jump = system.mass[:, None] * (state.v - self._last.v)
        impulse = None
        if jump.any():
            self._work += system.kinetic_energy(state.v) - system.kinetic_energy(self._last.v)
            gained = system.wrench(state.x, jump)
            self._impulse = self._impulse + gained
            impulse = gained[0]
        self._last = state
        self.go_on(system)
        return impulse

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins at the last state: powers may jump there."""
        self._system = part
        last = self._last
        self._rates = self._rates_at(last.t, last.x, last.v)

    def _share(self, state: State, rates: _Rates) -> Share:
        last, h = self._last, state.t - self._last.t
        peak = self._system.peak_tension(state.x)
        if h == 0.0:  # at the start, or the clock stands still in a run that is about to fail
            return NOTHING._replace(peak_tension=peak)
        x = 0.5 * (last.x + state.x) + 0.125 * h * (last.v - state.v)
        v = 1.5 / h * (state.x - last.x) - 0.25 * (last.v + state.v)
        middle = self._rates_at(last.t + 0.5 * h, x, v)
        (d0, w0, p0), (d1, w1, p1), (d2, w2, p2) = self._rates, middle, rates
        impulse, angular = h / 6 * (p0 + 4 * p1 + p2)
        return Share(h / 6 * (d0 + 4 * d1 + d2), h / 6 * (w0 + 4 * w1 + w2), impulse, peak, angular)

    def _rates_at(self, t: float, x: FloatArray, v: FloatArray) -> _Rates:
        _, dissipated, external, wrench = self._system.powers(t, x, v)
        if self._held:
            _, v_d, a_d = self._drive.at(self._system.inside(t))
            reactions = self._system.reactions(t, x, v, a_d)
            external += float(np.vdot(reactions, v_d))
            wrench = wrench + self._system.wrench(x, reactions)
        return _Rates(dissipated, external, wrench)

    def _reported(self, share: Share) -> EnergyBalance:
        total = self._impulse + np.stack((share.external_impulse, share.external_angular_impulse))
        return EnergyBalance(
            self._dissipated + share.dissipated_energy,
            self._work + share.external_work,
            tuple(total[0].tolist()),
            max(self._peak, share.peak_tension),
            tuple(total[1].tolist()),
        )
