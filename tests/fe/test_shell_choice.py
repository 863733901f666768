"""Names of shell elements: defaults and errors."""

import numpy as np
import pytest
from samples.shell_element_samples import element_mass, element_stiffness, isotropic, one_triangle

from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.single_cells import element_strains
from plymotion.preprocess.shell.shell_cells import ShellError


@pytest.mark.parametrize(
    ("membrane", "drilling", "form"),
    [
        ("opt", "auto", "none"),
        ("allman", "auto", "none"),
        ("cst", "auto", "tie"),
        ("cst", "fictitious", "fictitious"),
        ("opt", "tie", "tie"),
        ("cst", "none", "none"),
    ],
)
def test_drilling(membrane, drilling, form) -> None:
    assert Choice(membrane=membrane, drilling=drilling).checked().drilling_form() == form


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (Choice(plate="dktm"), r"plate 'dktm': expected one of dkmt, .*did you mean 'dkt'"),
        (Choice(membrane="CST"), r"membrane 'CST': expected one of opt, allman, cst"),
        (Choice(drilling="ties"), r"drilling 'ties': .* did you mean 'tie'"),
        (Choice(beta0="filippa"), r"beta0 'filippa': expected a number above 0 or \"felippa\""),
        (Choice(beta0=0.0), r"beta0 0.0: expected a number above 0"),
        (Choice(beta0=float("nan")), r"beta0 nan: expected a number above 0"),
        (Choice(drilling_factor=-1.0), r"drilling_factor -1.0: expected above 0"),
    ],
)
def test_unknown_names_and_numbers_are_refused(wrong, message) -> None:
    t, _, _ = one_triangle()
    with pytest.raises(ShellError, match=message):
        element_stiffness(t, isotropic(0.1), wrong)
    with pytest.raises(ShellError, match=message):
        element_strains(t, isotropic(0.1), wrong, np.zeros((1, 18, 1)))


def test_unknown_mass_form_is_refused() -> None:
    t, _, _ = one_triangle()
    with pytest.raises(ShellError, match="mass form 'lump': expected one of consistent, lumped"):
        element_mass(t, np.array([1.0, 0, 0]), "lump")
