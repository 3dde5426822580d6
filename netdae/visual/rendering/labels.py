"""What is written on a flight's pictures: the time, and a footer with scale bar, signs and colour bar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from netdae.visual.rendering.colours import (
    BULLET,
    CHASER,
    HELD,
    INK,
    PALE,
    PANEL,
    PAPER,
    STRONG,
    round_down,
    tension_map,
)
from netdae.visual.rendering.frames import KINDS, Cast
from netdae.visual.rendering.scene import Pixels

_BAR = 0.2  # of the width: the longest scale bar, and the colour bar


def font_size(width: int) -> int:
    """Size of the letters on a picture of that width, pixels."""
    return int(np.clip(width / 56, 9, 24))


def footer_height(width: int) -> int:
    """Height of the footer below a picture of that width, pixels."""
    return round(3.4 * font_size(width))


def time_text(t: float, decimals: int) -> str:
    """The time as pictures show it."""
    return f"t = {t:.{decimals}f} s"


def with_time(pixels: Pixels, text: str, *, size: float) -> Image.Image:
    """The picture with the time in its upper left corner, in letters of that size."""
    picture = Image.fromarray(pixels)
    ImageDraw.Draw(picture).text((0.8 * size, 0.6 * size), text, fill=INK, font=_font(size))
    return picture


@dataclass(frozen=True, eq=False)
class Footer:
    """The line below a picture: scale bar, signs of what is shown, colour bar.

    scale : m per pixel; peak : N, where the colours end
    held : whether a node is held or driven
    """

    cast: Cast
    scale: float
    peak: float
    held: bool = False

    def draw(self, width: int) -> Image.Image:
        """The footer, `footer_height(width)` high; signs that do not fit are left out."""
        size = font_size(width)
        image = Image.new("RGB", (width, footer_height(width)), PAPER)
        pen = _Pen(image, size)
        left = self._scale_bar(pen, size)
        right = self._colour_bar(pen, width - size)
        pen.signs(_signs_of(self.cast, held=self.held), left + 1.6 * size, right - 1.6 * size)
        return image

    def _scale_bar(self, pen: _Pen, left: float) -> float:
        length = round_down(_BAR * pen.image.width * self.scale)
        end = left + length / self.scale
        y = 1.9 * pen.size
        thick = max(1, round(pen.size / 8))
        pen.ink.line([(left, y), (end, y)], fill=INK, width=thick)
        for x in (left, end):
            pen.ink.line([(x, y - 0.35 * pen.size), (x, y + 0.35 * pen.size)], fill=INK, width=thick)
        pen.text((left + end) / 2, y - 0.45 * pen.size, length_text(length), anchor="ms")
        return max(end, left + 3 * pen.size)

    def _colour_bar(self, pen: _Pen, right: float) -> float:
        wide, y, high = int(_BAR * pen.image.width), 1.25 * pen.size, 0.65 * pen.size
        right -= 1.2 * pen.size  # the last number stands below the end
        left = right - wide
        colours = (255 * tension_map(wide)).round().astype(np.uint8)
        strip = np.repeat(colours[None], max(2, round(high)), axis=0)
        pen.image.paste(Image.fromarray(strip), (round(left), round(y)))
        for share in (0.0, 0.5, 1.0):
            more = "+" if share == 1 else ""
            pen.text(
                left + share * wide, y + high + 0.15 * pen.size, f"{share * self.peak:g}{more}", anchor="ma"
            )
        pen.text((left + right) / 2, y - 0.25 * pen.size, "tension, N", anchor="ms")
        return left - 0.5 * pen.size


@dataclass(frozen=True)
class _Sign:
    word: str
    shape: str  # "line", "ball", "cone" or "box"
    colour: str


def _signs_of(cast: Cast, *, held: bool) -> list[_Sign]:
    signs = [_Sign("slack", "line", PALE["net"])]
    for kind, name in enumerate(KINDS):
        if kind and (cast.kind == kind).any():
            signs.append(_Sign("closing cord" if name == "closing" else name, "line", STRONG[name]))
    if len(cast.bullets):
        signs.append(_Sign("bullets" if len(cast.bullets) > 1 else "bullet", "ball", BULLET))
    if held:
        signs.append(_Sign("held or driven", "cone", HELD))
    if len(cast.chaser):
        signs.append(_Sign("chaser", "box", CHASER))
    return signs


class _Pen:
    """Draws on the footer in letters of one size."""

    def __init__(self, image: Image.Image, size: int) -> None:
        self.image = image
        self.size = size
        self.ink = ImageDraw.Draw(image)
        self._letters = _font(size * 0.86)

    def text(self, x: float, y: float, text: str, *, anchor: str) -> None:
        self.ink.text((x, y), text, fill=INK, font=self._letters, anchor=anchor)

    def signs(self, signs: Sequence[_Sign], left: float, right: float) -> None:
        """Signs with their words, spread between left and right."""
        size = self.size
        widths = [2.0 * size + self.ink.textlength(sign.word, font=self._letters) for sign in signs]
        while signs and sum(widths) + size * (len(signs) - 1) > right - left:
            signs, widths = signs[:-1], widths[:-1]
        if not signs:
            return
        gap = min(2.0 * size, (right - left - sum(widths)) / max(1, len(signs)))
        x = left + (right - left - sum(widths) - gap * (len(signs) - 1)) / 2
        y = 1.6 * size
        for sign, width in zip(signs, widths, strict=True):
            self._sign(sign, x, y)
            self.text(x + 1.8 * size, y, sign.word, anchor="lm")
            x += width + gap

    def _sign(self, sign: _Sign, x: float, y: float) -> None:
        size, ink = self.size, self.ink
        if sign.shape == "line":
            thick = max(1, round(size / (9 if sign.colour == PALE["net"] else 5)))
            ink.line([(x, y), (x + 1.4 * size, y)], fill=sign.colour, width=thick)
        elif sign.shape == "ball":
            ink.ellipse([x + 0.35 * size, y - 0.4 * size, x + 1.15 * size, y + 0.4 * size], fill=sign.colour)
        elif sign.shape == "cone":
            foot = y + 0.4 * size
            ink.polygon(
                [(x + 0.7 * size, y - 0.4 * size), (x + 1.1 * size, foot), (x + 0.3 * size, foot)],
                sign.colour,
            )
        else:
            ink.rectangle([x, y - 0.25 * size, x + 1.4 * size, y + 0.25 * size], fill=PANEL)
            ink.rectangle([x + 0.4 * size, y - 0.35 * size, x + size, y + 0.35 * size], fill=sign.colour)


def length_text(length: float) -> str:
    """A length in the unit that makes it short."""
    for unit, metres in (("km", 1e3), ("m", 1.0), ("cm", 1e-2)):
        if length >= metres * (1 - 1e-9):
            return f"{length / metres:g} {unit}"
    return f"{length / 1e-3:g} mm"


def _font(size: float) -> Any:
    return ImageFont.load_default(size)


def framed(panel: Image.Image, footer: Image.Image) -> Image.Image:
    """A picture with its footer below."""
    whole = Image.new("RGB", (max(panel.width, footer.width), panel.height + footer.height), PAPER)
    whole.paste(panel, (0, 0))
    whole.paste(footer, (0, panel.height))
    return whole
