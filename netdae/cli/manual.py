"""`netdae manual`: the pages of the manual."""

from __future__ import annotations

from typing import TYPE_CHECKING

from netdae.core.errors import InputError

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable


def manual(page: str | None = None) -> None:
    """List the pages of the manual, or print one as Markdown.

    Parameters
    ----------
    page
        Name of a page; without it the pages are listed.
    """
    pages = _pages()
    if page is None:
        wide = max(map(len, pages))
        for name, file in pages.items():
            print(f"{name:<{wide}}  {sentence_of(file.read_text(encoding='utf-8'))}")
        return
    if page not in pages:
        raise InputError(_unknown(page, list(pages)))
    print(pages[page].read_text(encoding="utf-8"), end="")


def sentence_of(text: str) -> str:
    """The sentence under the title of a page, which says what the page holds."""
    return next(line for line in text.splitlines()[1:] if line.strip())


def _pages() -> dict[str, Traversable]:
    """Name to file of every page, in alphabetical order."""
    from importlib.resources import files

    found = {
        file.name.removesuffix(".md"): file
        for file in files("netdae.manual").iterdir()
        if file.name.endswith(".md")
    }
    return dict(sorted(found.items()))


def _unknown(page: str, names: list[str]) -> str:
    from difflib import get_close_matches

    near = get_close_matches(page.lower(), names, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}? The" if near else "the"
    return f"there is no page {page!r}: {hint} manual has {', '.join(names)}"
