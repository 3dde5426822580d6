"""The cases by name: every module of `cases/` that is there."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from netdae.core.errors import InputError
from netdae.runs.verification import cases
from netdae.runs.verification.case import Case


@cache
def all_cases() -> dict[str, Case]:
    """Every case by its name, in alphabetical order of the modules."""
    modules = [import_module(f"{cases.__name__}.{each.name}") for each in iter_modules(cases.__path__)]
    found: list[Case] = [module.CASE for module in modules]
    by_name = {case.name: case for case in found}
    assert len(by_name) == len(found), "two cases have one name"
    return by_name


def case_named(name: str) -> Case:
    """The case of that name; raises InputError with the nearest."""
    known = all_cases()
    if name not in known:
        near = get_close_matches(name.lower().replace("_", "-"), known, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}? There" if near else "there"
        raise InputError(f"there is no case {name!r}: {hint} are {', '.join(known)}")
    return known[name]
