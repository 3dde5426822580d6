"""The small shot that tests fly as a scenario: its text, and its file."""

from __future__ import annotations

from pathlib import Path


def shot(
    *,
    title: str = "small shot",
    side: float = 1.0,
    cells: int = 4,
    youngs_modulus: float | str = "1e9",
    density: float = 1390,
    strength: float | None = None,
    viscosity_time: float | str | None = "1e-4",
    mass: float = 0.05,
    scale: float = 0.8,
    speed: float = 5.0,
    half_angle_deg: float = 60,
    sections: str = "",
    method: str | None = None,
    end: float = 0.1,
    accuracy: str | None = "fast",
    frames: int | None = 5,
) -> str:
    """Text of a scenario: a small square net with a mass at each corner, shot by its corners.

    Numbers stand in it as Python prints them; where a test needs them written otherwise, they are given as text.
    None leaves the key out, and without frames the whole of [output].

    viscosity_time : of the dashpot; None for no damping
    scale : of the net at the start, along both of its sides
    sections : more sections, text that ends with a new line; they come before [solver]
    """
    damping = "none" if viscosity_time is None else "dashpot"
    output = "" if frames is None else f"[output]\nframes = {frames}\n"
    return f"""\
title = "{title}"
[net]
kind = "square"
side = {side}
cells = {cells}
[[material]]
youngs_modulus = {youngs_modulus}
density = {density}
diameter = 1e-3
{_line("strength", strength)}[damping]
kind = "{damping}"
{_line("viscosity_time", viscosity_time)}[[masses]]
group = "corners"
mass = {mass}
[initial]
scale = [{scale}, {scale}, 1.0]
[[initial.ejection]]
group = "corners"
speed = {speed}
half_angle_deg = {half_angle_deg}
{sections}[solver]
{_line("method", method and f'"{method}"')}end = {end}
{_line("accuracy", accuracy and f'"{accuracy}"')}{output}"""


def _line(key: str, value: object) -> str:
    return "" if value is None else f"{key} = {value}\n"


def write_shot(folder: Path, text: str) -> Path:
    """The text as shot.toml in the folder, which is made where there is none."""
    folder.mkdir(exist_ok=True)
    file = folder / "shot.toml"
    file.write_text(text, encoding="utf-8")
    return file
