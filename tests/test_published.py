"""Results of other codes' verification manuals: those that are no case of `netdae verify` by themselves."""

import numpy as np
import pytest

from netdae.runs.verification.cases.string_under_tension import DENSITY, frequencies_of


def test_density_of_vm53_belongs_to_the_drawn_string():
    # with ρ taken for ρ̄ the same string is lighter by L̄/l and higher by the root of it, 2.7e-3
    kept, stretch, _ = frequencies_of(20)
    lighter, _, _ = frequencies_of(20, DENSITY / stretch)
    np.testing.assert_allclose(lighter / kept, stretch**0.5, rtol=1e-9)
    assert stretch**0.5 - 1 == pytest.approx(2.7e-3, rel=0.02)
