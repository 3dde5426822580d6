"""Errors that a user can fix, and the one error for a failed run."""

from __future__ import annotations


class NetdaeError(Exception):
    """Anything netdae raises on purpose; bugs keep their own exceptions."""


class InputError(NetdaeError, ValueError):
    """A user's mistake: the message names the thing, what was found, what is expected, the next step."""


class MeshError(InputError):
    """A mesh file that cannot be read as a net, or a net that cannot be written."""


class ScenarioError(InputError):
    """A scenario file with a wrong section, key or value."""


class RunError(NetdaeError, RuntimeError):
    """A run that failed midway: the message says when, why, and which node or cable is worst."""
