"""The coefficients of Dormand and Prince are those of SciPy, digit by digit."""

import numpy as np
import pytest
from scipy.integrate import DOP853, RK45

from plymotion.solver.integrators.generic.dormand_prince import ORDER_5, ORDER_8

OF_8 = {"A": DOP853.A, "B": DOP853.B, "C": DOP853.C, "D": DOP853.D}
OF_8 |= {"E": np.stack((DOP853.E5[:-1], DOP853.E3[:-1]))}
OF_8 |= {"A_extra": DOP853.A_EXTRA, "C_extra": DOP853.C_EXTRA}
OF_5 = {"B": RK45.B, "C": RK45.C, "D": RK45.P.T, "E": RK45.E[None]}
OF_5 |= {"A": np.hstack((RK45.A, np.zeros((6, 1))))}


@pytest.mark.parametrize(("ours", "theirs"), [(ORDER_8, OF_8), (ORDER_5, OF_5)])
def test_coefficients(ours, theirs):
    for name, values in theirs.items():
        np.testing.assert_array_equal(getattr(ours, name), values, err_msg=name)
    assert DOP853.E5[-1] == DOP853.E3[-1] == 0.0  # columns that the table leaves out
