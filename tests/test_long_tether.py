"""Forces of an orbit act in each step: a long tether at rest along the radius keeps its tension."""

import pytest

from netdae.runs.verification.cases.long_tether import CASE, STIFFNESSES, TENSION, held


@pytest.mark.parametrize("setting", CASE.settings, ids=lambda setting: setting.label)
@pytest.mark.parametrize("EA", STIFFNESSES)
def test_tension_is_that_of_the_gravity_gradient(EA, setting):
    """Given as impulses some seconds apart the forces rang the tether: −70 to +54 % at EA = 1e5 N."""
    assert pytest.approx(0.0670, abs=5e-5) == TENSION
    held(setting, EA).require()
