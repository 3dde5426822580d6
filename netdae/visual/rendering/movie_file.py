"""Movies: pictures one after the other as .gif, which needs nothing more, or as .mp4, which needs imageio-ffmpeg.

A GIF's colours are one palette for the whole movie, made of those that a flight's pictures have, so that nothing
flickers.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.core.files import write_whole
from netdae.visual.rendering.colours import BULLET, CHASER, PALE, PANEL, STRONG, tension_map

MOVIE_ENDINGS = (".mp4", ".gif")

_LEVELS = 64
_QUALITY = "18"  # x264's constant rate factor; thin coloured lines suffer first


def best_ending() -> str:
    """.mp4 where it can be written, else .gif."""
    return ".mp4" if find_spec("imageio_ffmpeg") else ".gif"


def write_movie(file: Path, pictures: Iterator[Image.Image], *, rate: float) -> None:
    """Write pictures, all of one size, as a movie of `rate` pictures a second.

    A GIF counts in hundredths of a second: its rate is the nearest possible one. Raises OSError where the
    file cannot be written, InputError for .mp4 without imageio-ffmpeg.
    """
    if file.suffix.lower() == ".gif":
        write_whole(file, _gif(pictures, rate))
    else:
        _write_mp4(file, pictures, rate)


def check_ending(file: Path) -> None:
    """Raise InputError where a movie of that name cannot be written, before anything is drawn."""
    if file.suffix.lower() != ".mp4":
        return
    instead = "or give a name that ends in .gif"
    if find_spec("imageio_ffmpeg") is None:
        raise InputError(
            f"{file}: MP4 needs the package imageio-ffmpeg: pip install 'netdae[movie]', {instead}"
        )
    from imageio_ffmpeg import get_ffmpeg_exe

    try:
        get_ffmpeg_exe()
    except RuntimeError as error:
        raise InputError(
            f"{file}: MP4 needs ffmpeg, which imageio-ffmpeg has not here: install it, {instead}"
        ) from error


def _gif(pictures: Iterator[Image.Image], rate: float) -> bytes:
    palette = _palette()
    nearest = _nearest_of(palette)
    frames = []
    for picture in pictures:
        r, g, b = np.moveaxis((np.asarray(picture).astype(np.uint16) * _LEVELS) >> 8, 2, 0)
        frames.append(Image.fromarray(nearest[r, g, b]))
        frames[-1].putpalette(palette.ravel().tolist())
    data = io.BytesIO()
    frames[0].save(
        data,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=10 * max(2, round(100 / rate)),  # ms; browsers slow down what is faster than 20 ms
        loop=0,
        optimize=False,
    )
    return data.getvalue()


def _nearest_of(palette: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Index of the palette's nearest colour for each colour in `_LEVELS` steps of red, green and blue."""
    from scipy.spatial import KDTree

    step = np.linspace(0, 255, _LEVELS)  # the ends exactly: paper stays white
    colours = np.stack(np.meshgrid(step, step, step, indexing="ij"), axis=-1)
    return KDTree(palette).query(colours)[1].astype(np.uint8)


def _palette() -> NDArray[np.uint8]:
    """256 colours (256, 3): tensions and signs in light and shade, and greys."""
    tensions = tension_map(34)
    named = (*STRONG.values(), *list(PALE.values())[1:], CHASER, PANEL, BULLET)
    signs = np.array([[int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)] for colour in named])
    shades = [
        *(_lit(tensions, light) for light in (-0.25, 0.0, 0.25, 0.5, 0.75)),
        *(_lit(signs, light) for light in (-0.4, -0.2, 0.0, 0.35, 0.7)),
    ]
    greys = np.repeat(np.linspace(0, 1, 256 - sum(map(len, shades)))[:, None], 3, axis=1)
    colours = np.concatenate([greys[::-1], *shades])[:256]
    return (255 * colours).round().clip(0, 255).astype(np.uint8)


def _lit(colours: FloatArray, light: float) -> FloatArray:
    """The colours towards black, −1, or white, 1."""
    return (1 - abs(light)) * colours + max(0.0, light)


def _write_mp4(file: Path, pictures: Iterator[Image.Image], rate: float) -> None:
    from imageio_ffmpeg import write_frames

    partial = file.with_name(f"{file.stem}.part.mp4")  # ffmpeg takes the format from the ending
    try:
        partial.touch()
        first = next(pictures)
        sink = write_frames(
            str(partial),
            first.size,
            fps=rate,
            codec="libx264",
            pix_fmt_out="yuv420p",  # what every player can show
            macro_block_size=2,
            quality=None,
            ffmpeg_log_level="error",
            output_params=["-crf", _QUALITY, "-preset", "medium", "-movflags", "+faststart"],
        )
        sink.send(None)
        try:
            sink.send(np.ascontiguousarray(first))
            for picture in pictures:
                sink.send(np.ascontiguousarray(picture))
        finally:
            sink.close()
        partial.replace(file)
    except BaseException:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise
