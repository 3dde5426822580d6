"""Time and distance at which a shot net is widest, over speed, half-angle, radius and mass of the bullets.

    python3 scripts/in_venv.py python scripts/trends.py

Flies square nets by the explicit method, prints a table and draws scripts/pictures/trends.png. Square nets of the
reference cord, drawn together to σ = 0.4, their corners shot; no gravity, no tether, a start disturbed by 1e-10 m.

Symbols: R radius of the circumcircle (half the diagonal), σR where the bullets start, v their speed, θ half-angle from
the axis; M_b mass of the four bullets, m of the net, μ = m/M_b; t and d time and way of the centre of mass when the
mouth is widest; ρ, E of the cord, c = √(E/ρ) the speed of its waves, τ viscosity time.

What the literature states. Zhang et al. (A simplified model for fast analysis of the deployment dynamics of
tethered-net in space, Advances in Space Research 68 (2021) 1960-1974, by its abstract) take R, M_b/m, v and θ for the
four parameters of a shot, and find that d is mainly set by R and θ. That d hardly depends on v and that t goes as 1/v
is reported of the same paper; both are measured here.

Why. (1) Nothing pulls from outside, so the bullets' momentum stays in the net: d = t v cos θ / (1 + μ), 0.2 % more
for the four knots that are shot with the bullets. That d does not depend on v, and that t goes as 1/v, is one
statement. (2) With lengths in R and times in R/v the equation of motion holds v only in v/c and τ v/R. For v/c → 0 at
the same τ c/R cables are rods that go taut at once, and a spring with a dashpot bounces alike at any speed, so that
t v/R is a function of θ, μ and σ alone. At their peak the cables strain by about 3 v/c. (3) Bullets that nothing
brakes come as far from the axis as the corners of the spread net, and the net's centre of mass as far along it, at

    t₀ = (1 − σ) R / (v sin θ),        d₀ = (1 − σ) R cot θ / (1 + μ).

(4) The net brakes them, most of all at the end: its cords are then nearly straight and are drawn outward at their
middle by a lever that grows without bound. Take one mass in the middle of a cord of half-length R between two bullets
at ±x, hanging back by y = √(R² − x²): ẏ = −x ẋ/y, and with ε the mass over that of both bullets the energy
½(ẋ² + ε ẏ²) of the spreading stays. Then ẋ = v sin θ / √(1 + ε x²/y²), and with x = R sin φ

    t/t₀ = 1/(1 − σ) ∫ √(cos² φ + ε sin² φ) dφ   from asin σ to π/2,

about 1 + ε (ln(4/√ε) − ½)/(2 (1 − σ)) where ε is small and σ² ≪ 1. How much of a net hangs back is left open:
ε = `LAGGING` μ, one number, fitted to θ = 45°, μ = 0.06. What is predicted is how t depends on μ and σ.

Found, 10 × 10 meshes, v 1.25 to 20 m/s (v/c 1.8e-4 to 2.8e-3), θ 20° to 75°, R 1.8 to 7.1 m, at μ = 0.06:

- t ~ v^p with p from −1.002 to −0.982; below 20 m/s −1.003 to −0.994. Eight starts that differ by 1e-10 m spread t
  by 0.7 %.
- d spreads over the speeds by 1 % (median) and at most 6 %, at 75° by 20 m/s; below 20 m/s by at most 1.4 %. What
  then shows is v/c: cables stretch, and the net opens later.
- t and d are proportional to R within 2 % at each angle, and fall with θ.
- t/t₀ is 1.07 to 1.20, largest at small θ. The lever, fitted at one point, is within 3 % for 20° to 45° and up to 8 %
  late at 75°: it does not know that the net hangs back along the axis too, farther where θ is small. At 45° it gives
  t over μ from 0.006 to 0.12 within 1 %; at μ = 0.24 the flight takes 6 % longer still.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ellipe, ellipeinc

import netdae as nd
from netdae.runs.workers import Tell, outcomes_of, processes_for

DENSITY, DIAMETER = 1390.0, 1e-3  # kg/m³, m
LINE = DENSITY * math.pi / 4 * DIAMETER**2  # kg/m
CORD = nd.Material(youngs_modulus=70e9, density=DENSITY, diameter=DIAMETER)
VISCOSITY_TIME = 1e-5  # s
SCALE = 0.4
BULLET = 0.1  # kg a metre of side: net and bullets keep their ratio in nets of any size
DISTURBANCE = 1e-10  # m; no real start is symmetric
LAGGING = 1.57
"""ε/μ of the lever."""

SPEEDS: tuple[float, ...] = (1.25, 2.5, 5.0, 10.0, 20.0)  # m/s
ANGLES: tuple[float, ...] = (20.0, 30.0, 45.0, 60.0, 75.0)  # °
SIDES: tuple[float, ...] = (2.5, 5.0, 10.0)  # m
BULLETS = (0.025, 0.05, 0.2, 0.4, 1.0)  # kg a metre, beside BULLET
WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 0.3}
FRAMES = 200  # looks in t₀
FALLEN = 0.8  # share of the largest mouth at which a flight is over
PATIENCE = 4  # t₀ after which it is over in any case


class Shot(NamedTuple):
    """One flight: speed in m/s, half-angle in degrees, side in m, mass of a bullet in kg a metre of side."""

    speed: float = 2.5
    angle: float = 45.0
    side: float = 5.0
    bullet: float = BULLET
    cells: int = 10
    seed: int = 0

    @property
    def radius(self) -> float:
        """R, m."""
        return self.side / math.sqrt(2)

    @property
    def mass_ratio(self) -> float:
        """μ = m/M_b."""
        return LINE * 2 * (self.cells + 1) / (4 * self.bullet)

    @property
    def ballistic_time(self) -> float:
        """t₀, s."""
        return (1 - SCALE) * self.radius / (self.speed * math.sin(math.radians(self.angle)))

    @property
    def drift(self) -> float:
        """Speed of the centre of mass, m/s; the knots of the corners are shot with their bullets."""
        shot = 1 + LINE / self.cells / self.bullet
        return self.speed * math.cos(math.radians(self.angle)) * shot / (1 + self.mass_ratio)


class Widest(NamedTuple):
    """When and where the mouth is widest: time in s, way of the centre of mass in m, area over the net's own."""

    time: float
    distance: float
    area: float


def fly(shot: Shot, *, cord: nd.Material = CORD, viscosity_time: float = VISCOSITY_TIME) -> Widest:
    """Fly a shot until its mouth has been widest."""
    net = nd.CableNet.square(side=shot.side, cells=shot.cells)
    masses, damping = {"corners": shot.bullet * shot.side}, nd.Dashpot(viscosity_time=viscosity_time)
    system = nd.System(net, cord, masses=masses, damping=damping)
    net, start = nd.scaled(net, [SCALE, SCALE, 1.0])
    start = nd.ejected(net, start, "corners", speed=shot.speed, half_angle_deg=shot.angle)
    noise = DISTURBANCE * np.random.default_rng(shot.seed).standard_normal(start.x.shape)
    start = nd.State.at(start.x + noise, start.v)
    times = shot.ballistic_time * np.arange(PATIENCE * FRAMES + 1) / FRAMES
    loop, share = nd.mouth_of(net, "border"), system.mass / system.mass.sum()
    areas: list[float] = []
    ways: list[float] = []
    for state in nd.integrate(system, start, times, options=nd.SolverOptions(method="explicit")):
        areas.append(nd.vector_area(state.x[loop]) / shot.side**2)
        ways.append(float(share @ (state.x - start.x)[:, 2]))
        if areas[-1] < FALLEN * max(areas):
            break
    else:
        raise nd.RunError(
            f"{shot}: the mouth has not closed again by {times[-1]:.3g} s: no largest area was found"
        )
    k = int(np.argmax(areas))
    before, here, after = areas[k - 1 : k + 2]
    offset = 0.5 * (before - after) / (before - 2 * here + after)  # of the parabola's top, in frames
    time = float(np.interp(k + offset, range(len(times)), times))
    return Widest(time, float(np.interp(time, times[: len(ways)], ways)), here)


def braked(shot: Shot) -> float:
    """t/t₀ of the lever."""
    m = 1 - LAGGING * shot.mass_ratio  # cos²φ + ε sin²φ = 1 − m sin²φ
    return float((ellipe(m) - ellipeinc(math.asin(SCALE), m)) / (1 - SCALE))


def fly_and_tell(shot: Shot, report: Tell) -> None:
    """The task of a worker."""
    report(fly(shot))


def flown(shots: Iterable[Shot], *, processes: int | None = None) -> dict[Shot, Widest]:
    """All shots, flown in parallel; raises RunError for one that fails."""
    items = list(dict.fromkeys(shots))
    found: dict[Shot, Widest] = {}

    def hear(number: int, widest: Any) -> None:
        found[items[number]] = widest

    count = processes_for(len(items), processes)
    for outcome in outcomes_of(fly_and_tell, items, processes=count, hear=hear):
        if outcome.error is not None:
            raise nd.RunError(f"{items[outcome.number]}: {outcome.bug or outcome.error}")
    return {shot: found[shot] for shot in items}


def slope_over_speed(shots: Sequence[Shot], found: dict[Shot, Widest]) -> float:
    """Exponent p of t ~ vᵖ by least squares."""
    logs = np.log([(shot.speed, found[shot].time) for shot in shots])
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def spread(values: Sequence[float]) -> float:
    """Largest less smallest, over the mean."""
    return (max(values) - min(values)) / float(np.mean(values))


def table(found: dict[Shot, Widest], grid: Sequence[Shot], heavier: Sequence[Shot]) -> str:
    """What was measured: a line for each angle and radius over all speeds, and one for each mass of bullets."""
    lines = ["    θ, °    R, m   t ~ v^p      d, m  spread, %    t/t₀  area, %"]
    for angle, side in dict.fromkeys((shot.angle, shot.side) for shot in grid):
        shots = [shot for shot in grid if (shot.angle, shot.side) == (angle, side)]
        ways = [found[shot].distance for shot in shots]
        late = [found[shot].time / shot.ballistic_time for shot in shots]
        area = 100 * float(np.mean([found[shot].area for shot in shots]))
        lines.append(
            f"{angle:8.0f}{side / math.sqrt(2):8.2f}{slope_over_speed(shots, found):10.4f}{np.mean(ways):10.3f}"
            f"{100 * spread(ways):11.1f}{np.mean(late):8.3f}{area:9.1f}"
        )
    lines += ["", "       μ    t/t₀   lever      d, m  area, %"]
    for shot in heavier:
        widest = found[shot]
        lines.append(
            f"{shot.mass_ratio:8.4f}{widest.time / shot.ballistic_time:8.3f}{braked(shot):8.3f}"
            f"{widest.distance:10.3f}{100 * widest.area:9.1f}"
        )
    return "\n".join(lines)


def draw(file: Path, found: dict[Shot, Widest], cells: int) -> None:
    """Time and distance against speed, radius, half-angle and mass ratio; lines are theory, marks are flights."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.lines import Line2D

    base = Shot(cells=cells)
    angles, sides = sorted({shot.angle for shot in found}), sorted({shot.side for shot in found})
    shades = {angle: str(0.62 * (1 - k / (len(angles) - 1))) for k, angle in enumerate(angles)}
    of_angles = [(base._replace(angle=a), shades[a], "osD^v"[k], "") for k, a in enumerate(angles)]
    of_sides = [
        (s := base._replace(side=side), "0.25", "PX*"[k], f"R = {s.radius:.1f} m")
        for k, side in enumerate(sides)
    ]
    of_base = [each for each in of_angles if each[0] == base]
    columns = (
        ("speed of the bullets, m/s", "speed", "speed", of_angles),
        ("radius of the net, m", "side", "radius", of_angles),
        ("half-angle, °", "angle", "angle", of_sides),
        ("mass of the net / mass of the bullets", "bullet", "mass_ratio", of_base),
    )
    figure, axes = plt.subplots(2, 4, figsize=(13.2, 6.6), sharex="col")
    for pair, (label, across, abscissa, series) in zip(axes.T, columns, strict=True):
        pair[1].set_xlabel(label)
        for first, shade, mark, name in series:
            where = getattr(first, across)
            shots = [shot for shot in found if shot._replace(**{across: where}) == first]
            ends = [getattr(shot, across) for shot in shots]
            line = [first._replace(**{across: w}) for w in np.geomspace(min(ends), max(ends), 60).tolist()]
            x = [getattr(shot, abscissa) for shot in shots]
            x_line = [getattr(shot, abscissa) for shot in line]
            for row, axis in enumerate(pair):
                free = [shot.ballistic_time * (shot.drift if row else 1.0) for shot in line]
                lever = [f * braked(shot) for f, shot in zip(free, line, strict=True)]
                axis.plot(x_line, free, color=shade, linewidth=0.9, linestyle=":")
                axis.plot(x_line, lever, color=shade, linewidth=0.9)
                axis.plot(x, [found[shot][row] for shot in shots], mark, color=shade, markersize=5.5)
            at = (x[0], found[shots[0]].time)
            pair[0].annotate(name, at, (8, 3), textcoords="offset points", fontsize=8, bbox=WHITE)
    _scale(axes, base)
    legend = [
        Line2D([], [], linestyle="none", marker=mark, color=shade, label=f"{shot.angle:.0f}°")
        for shot, shade, mark, _ in of_angles
    ]
    legend.append(
        Line2D([], [], color="0.3", linewidth=0.9, label="theory: bullets braked by the net's lever")
    )
    legend.append(
        Line2D([], [], color="0.3", linewidth=0.9, linestyle=":", label="bullets that nothing brakes")
    )
    figure.legend(handles=legend, loc="lower center", ncols=len(legend), fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0.055, 1, 1))
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=100)
    plt.close(figure)


def _scale(axes: Any, base: Shot) -> None:
    """Scales on which the claims are straight lines, and above each column what is the same in it."""
    radius, speed, ratio = (
        f"R = {base.radius:.1f} m",
        f"{base.speed:g} m/s",
        f"$m/M_\\mathrm{{b}}$ = {base.mass_ratio:.2f}",
    )
    titles = (
        f"{radius}, {ratio}",
        f"{speed}, {ratio}",
        f"{speed}, {ratio}",
        f"{radius}, {speed}, {base.angle:.0f}°",
    )
    for axis, title in zip(axes[0], titles, strict=True):
        axis.set_title(title, fontsize=9, color="0.3")
    axes[0, 0].set_ylabel("time of the widest mouth, s")
    axes[1, 0].set_ylabel("distance at the widest mouth, m")
    for axis in (*axes[:, 0], *axes[:, 3]):
        axis.set_xscale("log")
    axes[0, 0].set_yscale("log")
    rulers: tuple[tuple[Any, tuple[float, ...]], ...] = (
        (axes[0, 0].xaxis, SPEEDS),
        (axes[0, 0].yaxis, (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)),
        (axes[0, 3].xaxis, (0.01, 0.03, 0.1, 0.3)),
    )
    for ruler, ticks in rulers:
        ruler.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        ruler.set_ticks([], minor=True)
    for axis in (axes[1, 0], *axes[:, 1], *axes[:, 2]):
        axis.set_ylim(0, 1.06 * axis.get_ylim()[1])


def shots_of(cells: int, *, quick: bool = False) -> tuple[list[Shot], list[Shot]]:
    """The grid of speeds, angles and sides at one mass ratio; shots of several mass ratios."""
    thin = slice(None, None, 2) if quick else slice(None)
    grid = [
        Shot(speed, angle, side, cells=cells)
        for angle in ANGLES[thin]
        for side in (SIDES[:2] if quick else SIDES)
        for speed in (SPEEDS[1:4] if quick else SPEEDS)
    ]
    bullets = sorted({BULLET, *(BULLETS[2:4] if quick else BULLETS)})
    return grid, [Shot(bullet=bullet, cells=cells) for bullet in bullets]


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly the grid, print the table, draw the figure."""
    parser = argparse.ArgumentParser(description="Time and distance at which a shot net is widest.")
    pictures = Path(__file__).resolve().parent / "pictures"
    parser.add_argument("--out", type=Path, default=pictures / "trends.png", help="the figure")
    parser.add_argument("--cells", type=int, default=10, help="meshes a side")
    parser.add_argument("--processes", type=int, help="by default one for each processor")
    parser.add_argument("--quick", action="store_true", help="a grid of few points")
    asked = parser.parse_args(arguments)
    grid, heavier = shots_of(asked.cells, quick=asked.quick)
    found = flown([*grid, *heavier], processes=asked.processes)
    print(table(found, grid, heavier))
    draw(asked.out, found, asked.cells)


if __name__ == "__main__":
    main()
