"""How accurately a flight is integrated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from netdae.core.errors import InputError

Accuracy = Literal["fast", "standard", "accurate"]
Method = Literal["ida", "explicit", "cvode_bdf", "cvode_adams", "rk45", "dop853", "radau", "bdf", "lsoda"]
METHODS: tuple[Method, ...] = get_args(Method)

PRESETS: dict[Accuracy, tuple[float, float, float]] = {
    "fast": (1e-3, 1e-4, 1e-2),
    "standard": (1e-4, 1e-5, 3e-4),  # at 1e-3 m/s IDA itself takes 1 to 3 % of the energy of a 1 s flight
    "accurate": (1e-5, 1e-6, 1e-4),
}
"""rtol, atol_position in m, atol_velocity in m/s; `scripts/accuracy.py` measures what each achieves."""


FINEST_RTOL, COARSEST_RTOL = 1e-13, 0.1
"""Finer, round-off fails the error test and the flight creeps; coarser, the result means nothing."""


HIGHEST_ORDER = 5  # of IDA's BDF formulas


@dataclass(frozen=True)
class SolverOptions:
    """The method of a flight, its tolerances and limits.

    method : "ida", or "explicit" for the velocity Verlet, whose step length `accuracy` and `max_step` set; for
        comparison, CVODE (cvode_bdf, cvode_adams) and SciPy (rk45, dop853, radau, bdf, lsoda) on the same forces
    accuracy : preset of the three tolerances below, each of which overrides it
    rtol : relative tolerance of positions and velocities
    atol_position : m; atol_velocity : m/s
    max_order : of the BDF formulas, 1 to 5; 5 by default
    max_step : s; none by default
    products : "frozen" treats each Newton solve as exact, as a direct solver does; "true" lets GMRES iterate
        with the true Jacobian, which is slower and serves as a check of the former

    Raises InputError for values out of range.
    """

    method: Method = "ida"
    accuracy: Accuracy = "standard"
    rtol: float | None = None
    atol_position: float | None = None
    atol_velocity: float | None = None
    max_order: int | None = None
    max_step: float | None = None
    products: Literal["frozen", "true"] = "frozen"

    def __post_init__(self) -> None:
        if self.accuracy not in PRESETS:
            raise InputError(f"accuracy is {self.accuracy!r}: choose one of {', '.join(PRESETS)}")
        for name in ("rtol", "atol_position", "atol_velocity", "max_step"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} is {value:g}: give a finite number above zero")
        if self.rtol is not None and not FINEST_RTOL <= self.rtol <= COARSEST_RTOL:
            raise InputError(f"rtol is {self.rtol:g}: give {FINEST_RTOL:g} to {COARSEST_RTOL:g}")
        if self.method not in METHODS:
            raise InputError(f"method is {self.method!r}: choose one of {', '.join(METHODS)}")
        if self.method == "explicit":
            for name in ("rtol", "atol_position", "atol_velocity", "max_order"):
                if getattr(self, name) is not None:
                    raise InputError(
                        f"{name} says nothing to the explicit method: leave it out, or give max_step"
                    )
        elif self.method != "ida" and self.max_order is not None:
            raise InputError(f"max_order says nothing to the method {self.method}: leave it out")
        if self.max_order is not None and not 1 <= self.max_order <= HIGHEST_ORDER:
            raise InputError(f"max_order is {self.max_order}: the BDF formulas of IDA have order 1 to 5")

    @property
    def in_force(self) -> dict[str, float]:
        """The tolerances and the order that the method uses, by name; none for the explicit one."""
        if self.method == "explicit":
            return {}
        names = ("rtol", "atol_position", "atol_velocity")
        order = {"max_order": self.max_order or HIGHEST_ORDER} if self.method == "ida" else {}
        return {**dict(zip(names, self.tolerances, strict=True)), **order}

    def finer(self, step: float | None = None) -> str:
        """What to set for a finer integration, as in [solver]; `step` is the mean step of the flight, s."""
        presets = list(PRESETS)
        own = (self.rtol, self.atol_position, self.atol_velocity)
        left = presets[presets.index(self.accuracy) + 1 :]
        if self.method == "explicit":
            if left and self.max_step is None:
                return f'accuracy = "{left[0]}"'
            steps = [each for each in (step, self.max_step) if each is not None and each > 0]
            return f"max_step = {0.5 * min(steps):.2g}" if steps else "a smaller max_step"
        if left and own == (None, None, None):
            return f'accuracy = "{left[0]}"'
        rtol, atol_position, atol_velocity = (0.1 * each for each in self.tolerances)
        if rtol < FINEST_RTOL:
            return 'method = "explicit"'
        return (
            f"rtol = {rtol:.2g}, atol_position = {atol_position:.2g} and atol_velocity = {atol_velocity:.2g}"
        )

    @property
    def tolerances(self) -> tuple[float, float, float]:
        """rtol, atol_position and atol_velocity in force."""
        own = (self.rtol, self.atol_position, self.atol_velocity)
        preset = PRESETS[self.accuracy]
        return (
            preset[0] if own[0] is None else own[0],
            preset[1] if own[1] is None else own[1],
            preset[2] if own[2] is None else own[2],
        )
