"""Options of the solver: advice that can be followed."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from itertools import product

import pytest

from netdae.output.histories import FINER
from netdae.solvers.options import METHODS, PRESETS, SolverOptions

OWN = [{}, {"rtol": 1e-7}, {"rtol": 2e-13}, {"max_step": 1e-4}]


@pytest.mark.parametrize(("method", "accuracy", "own"), [*product(METHODS, PRESETS, OWN)])
def test_advice_for_a_finer_integration_can_be_followed_and_is_finer(method, accuracy, own):
    if method == "explicit" and "rtol" in own:
        pytest.skip("it has no tolerances")
    options, step = SolverOptions(method, accuracy=accuracy, **own), 1e-5
    given = tomllib.loads(re.sub(r",? (?:and )?(?=[a-z_]+ = )", "\n", options.finer(step)))
    if "method" in given:  # finer tolerances are below round-off
        assert given == {"method": "explicit"}
        assert own == {"rtol": 2e-13}
        return
    followed = replace(options, **given)
    if method == "explicit" and given.keys() == {"max_step"}:
        assert followed.max_step == 0.5 * step
    elif method == "explicit":
        assert list(PRESETS).index(followed.accuracy) == list(PRESETS).index(accuracy) + 1
    else:
        assert all(new < old for new, old in zip(followed.tolerances, options.tolerances, strict=True))


def test_without_options_the_advice_names_what_helps_at_accurate_too():
    assert "tolerances" in FINER
    assert "max_step" in FINER
