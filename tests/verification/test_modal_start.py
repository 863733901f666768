"""Initial modal coordinates and rates, and starts in equilibrium."""

import numpy as np
import pytest
from samples.beam_samples import clamped_file
from samples.case_samples import run_text

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError

CLAMP = """
[ground.root]
position = [0.0, 0.0, 0.0]
[bodies.beam]
kind = "package"
package = "beam.vtkhdf"
{more}
[joints.root]
kind = "fixed"
between = ["ground.root", "beam.root"]
[signals.tip]
kind = "deflection"
at = "beam.tip"
component = "y"
"""


@pytest.fixture
def beam(tmp_path):
    return clamped_file(tmp_path, 2)


def tip(package, k):
    interface = next(i for i in package.interfaces if i.name == "tip")
    return interface.phi_B[1, k]


@pytest.mark.parametrize("word", ['"bending-xy 2"', '"2"'])
def test_a_mode_swings_from_its_start(beam, tmp_path, word):
    """Of a clamped body at rest, modes do not couple: a cosine and a sine."""
    w = beam.frequencies[1]
    more = f"modal_coordinates = {{ {word} = 1e-3 }}\nmodal_rates = {{ {word} = {0.5e-3 * w} }}"
    t_end = 2.0 * np.pi / w
    t, found, summary = run_text(tmp_path, CLAMP.format(more=more), t_end=t_end, step=t_end / 40)
    assert "loads-begin-suddenly" not in {w["code"] for w in summary["warnings"]}  # it is meant
    expected = 1e-3 * (np.cos(w * t) + 0.5 * np.sin(w * t)) * tip(beam, 1)
    np.testing.assert_allclose(found["tip"], expected, atol=1e-8 * np.abs(expected).max())


def test_rates_that_are_not_given_stay_free(beam, tmp_path):
    """With modes_at_start = "free" the given rate is kept, the other is of least energy: zero."""
    w = beam.frequencies[0]
    more = 'modal_rates = { "bending-xy 1" = 1e-3 }'
    t, found, _ = run_text(
        tmp_path, CLAMP.format(more=more), t_end=0.1 / w, step=0.01 / w,
        more='modes_at_start = "free"',
    )  # fmt: skip
    expected = 1e-3 / w * np.sin(w * t) * tip(beam, 0)
    np.testing.assert_allclose(found["tip"], expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('modal_coordinates = { "bending-xz 1" = 1.0 }', "did you mean 'bending-xy 1'"),
        ('modal_rates = { "7" = 1.0 }', 'bodies.beam.modal_rates = "7": no such mode'),
        ('modal_rates = { "1" = 1.0, "bending-xy 1" = 2.0 }', "expected each mode once"),
    ],
)
def test_wrong_names_are_told(beam, tmp_path, more, words):
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        run_text(tmp_path, CLAMP.format(more=more), t_end=1.0, step=0.1)


def test_rigid_bodies_have_no_modes(tmp_path, capsys):
    text = CLAMP.format(more="").replace('kind = "package"\npackage = "beam.vtkhdf"', "")
    body = 'kind = "rigid"\nmass = 1.0\ninertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n'
    body += 'interfaces = { root = { position = [0, 0, 0] } }\nmodal_rates = { "1" = 1.0 }\n'
    text = text.replace("[bodies.beam]\n", "[bodies.beam]\n" + body).split("[signals")[0]
    (tmp_path / "case.toml").write_text(
        'format = 1\ntitle = "x"\n' + text + "[solver]\nt_end = 1.0\noutput_step = 0.1\n[runs.a]\n"
    )
    assert main(["check", str(tmp_path / "case.toml")]) == 2
    assert "bodies.beam.modal_rates" in capsys.readouterr().err
