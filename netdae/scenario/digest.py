"""Digests of a scenario and of the files that it reads, by which a later process sees that they are the same."""

from __future__ import annotations

import hashlib
from pathlib import Path

from netdae.core.errors import InputError
from netdae.core.files import reason_of
from netdae.scenario.reader import Scenario


def digests_of(scenario: Scenario, text: bytes) -> list[str]:
    """SHA-256 of the text, and of each file that the scenario reads, in their order.

    text : the scenario's, or that of its copy

    Raises InputError for a file that cannot be read.
    """
    return [_digest(text), *(_digest(_content_of(file)) for file in scenario.files)]


def check_digests(scenario: Scenario, expected: list[str], *, since: str) -> None:
    """Raise InputError, which names the file, unless the scenario and its files have those digests.

    since : what was written when they had them
    """
    if _digest(scenario.text) != expected[0]:
        raise InputError(
            f"{scenario.path} has changed since {since}: put it back, or fly it afresh into another folder"
        )
    for file, digest in zip(scenario.files, expected[1:], strict=True):
        if _digest(_content_of(file)) != digest:
            raise InputError(
                f"{file}, which {scenario.path} reads, has changed since {since}: put it back, or fly the "
                "scenario afresh into another folder"
            )


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _content_of(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InputError(
            f"{file}, which the scenario reads, cannot be read: {reason_of(error)}: put it back"
        ) from error
