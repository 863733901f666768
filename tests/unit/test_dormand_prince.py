"""The coefficients of Dormand and Prince are those of SciPy, digit by digit."""

import numpy as np
import pytest
from scipy.integrate import DOP853, RK45

from plymotion.solver.integrators.generic.dormand_prince import Order5, Order8

NAMES = {
    (Order8, DOP853): ("A", "B", "C", "E3", "E5", "D", "A_EXTRA", "C_EXTRA"),
    (Order5, RK45): ("A", "B", "C", "E", "P"),
}


@pytest.mark.parametrize(
    ("ours", "theirs", "name"), [(*pair, name) for pair, names in NAMES.items() for name in names]
)
def test_coefficients(ours: type, theirs: type, name: str) -> None:
    np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
