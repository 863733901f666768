"""Modes of beams in steady spin, by the command `plymotion modes`, against tables."""

import numpy as np
import pytest
from peers.spinning_beam import flap
from samples.beam_samples import CLAMPED, reduced
from samples.case_samples import run_text
from samples.modes_samples import modes_at, rates

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.errors import InputError
from plymotion.solver.package import write_package

# Slender to the limit of a Bernoulli beam that cannot be stretched: EI = rhoA = L = 1.
K = np.diag([1e8, 1e8, 1e8, 1.0, 1.0, 1.0])
MASS = SectionMass(1.0, np.zeros(3), np.diag([2e-10, 1e-10, 1e-10])).matrix()
CASE = """
[ground.axis]
position = [0.0, 0.0, 0.0]
[bodies.hub]
kind = "rigid"
mass = 1.0
inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
interfaces = {{ axis = {{ position = [0.0, 0.0, 0.0] }}, rim = {{ position = [{hub}, 0.0, 0.0] }} }}
[bodies.blade]
kind = "package"
package = "blade.vtkhdf"
position = [{hub}, 0.0, 0.0]
[joints.axis]
kind = "revolute"
between = ["ground.axis", "hub.axis"]
axis = [0.0, 0.0, 1.0]
drive = {{ speed = 1.0 }}
[joints.root]
kind = "fixed"
between = ["hub.rim", "blade.root"]
"""
STIFFENED = "geometric_stiffening = true\n"


@pytest.fixture(scope="module")
def table(published):
    return published("rotating_beam")


def blade_beside(folder, modes):
    package = reduced(CLAMPED, modes, elements=20, K=K, mass=MASS).package
    (folder / "sample").mkdir(parents=True, exist_ok=True)
    write_package(folder / "sample" / "blade.vtkhdf", package)


def campbell(folder, capsys, modes, at, hub=0.0, *options):
    blade_beside(folder, modes)
    text = CASE.format(hub=hub)
    return modes_at(folder, text, at, *options, capsys=capsys, more=STIFFENED)


@pytest.mark.parametrize(
    "modes",
    [
        [{"kind": "bending-xz", "count": 12}],
        [{"kind": "spinning-xz", "count": 2}, {"kind": "bending-xz", "count": 4}],
    ],
)
def test_flap_over_speed(modes, table, tmp_path, capsys):
    """Branches are followed to the third flap mode; crossings with 1P do not exist."""
    found = campbell(tmp_path, capsys, modes, "spin=0:12:2", 0.0, "--count", "3")
    expected = table["no-hub"]
    rows = [expected["mu"].index(int(speed)) for speed in found["speeds"]]
    for k, branch in enumerate(found["branches"]):
        known = [expected[f"flap_{k + 1}"][row] for row in rows]
        np.testing.assert_allclose(branch["angular_frequency"], known, rtol=table["tolerance"])
    assert all(x["harmonic"] > 1 for x in found["crossings"])
    assert found["least_overlap"] > 0.8


def test_the_table_is_that_of_power_series(table):
    """A route without trial functions, exact to round-off."""
    known = table["no-hub"]
    for row in (1, 4, 9):
        wanted = [known[f"flap_{k}"][row] for k in (1, 2, 3)]
        assert flap(known["mu"][row], 0.0, 3) == pytest.approx(wanted, abs=6e-7)
    known = table["hub"]
    assert flap(known["mu"][-1], 1.0, 1) == pytest.approx(known["flap_1"][-1:], abs=6e-6)


def test_three_flap_modes_on_a_hub(tmp_path, capsys):
    modes = [{"kind": "spinning-xz", "count": 3}, {"kind": "bending-xz", "count": 4}]
    found = campbell(tmp_path, capsys, modes, "spin=0:10:5", 1.0, "--count", "3")
    for row, speed in enumerate(found["speeds"]):
        values = [branch["angular_frequency"][row] for branch in found["branches"]]
        np.testing.assert_allclose(values, flap(speed, 1.0, 3), rtol=1e-4)


def test_flap_on_a_hub_crosses_its_harmonics(table, tmp_path, capsys):
    modes = [{"kind": "spinning-xz", "count": 4}]
    found = campbell(tmp_path, capsys, modes, "spin=0:10:2", 1.0, "--count", "1")
    expected = table["hub"]
    flap = found["branches"][0]["angular_frequency"]
    np.testing.assert_allclose(flap[1:], expected["flap_1"], rtol=table["tolerance"])
    second = next(x for x in found["crossings"] if x["harmonic"] == 2)
    assert second["angular_frequency"] == pytest.approx(2.0 * second["speed"])
    there = modes_at(
        tmp_path, CASE.format(hub=1.0), f"spin={second['speed']}", capsys=capsys, more=STIFFENED
    )
    assert rates(there)[0] == pytest.approx(2.0 * second["speed"], rel=1e-6)


def test_lag_in_the_plane_of_rotation(table, tmp_path, capsys):
    modes = [{"kind": "spinning-xy", "count": 4}]
    found = campbell(tmp_path, capsys, modes, "spin=2:12:2", 0.0, "--count", "1")
    expected = table["no-hub"]
    known = [expected["chord_1"][expected["mu"].index(int(speed))] for speed in found["speeds"]]
    lag = found["branches"][0]["angular_frequency"]
    np.testing.assert_allclose(lag, known, rtol=table["tolerance"])


def test_linear_body_softens_in_the_plane_until_it_is_unstable(tmp_path, capsys):
    """Without second-order terms the lag frequency falls to zero at the frequency at rest."""
    blade_beside(tmp_path, [{"kind": "spinning-xy", "count": 4}])
    text = CASE.format(hub=0.0)
    slow = modes_at(tmp_path, text, "spin=3.4", capsys=capsys)
    fast = modes_at(tmp_path, text, "spin=3.6", capsys=capsys)
    assert slow["modes"][0]["angular_frequency"] < 1.0
    growing = [m for m in fast["modes"] if m["kind"] == "real" and m["eigenvalue"][0] > 0]
    assert len(growing) == 1
    assert any("unstable" in note for note in fast["notes"])


STEADY = 'start = "equilibrium"\nspin = { axis = [0.0, 0.0, 1.0], speed = 6.0 }\n' + STIFFENED
SIGNALS = """
[signals.stretch]
kind = "deflection"
at = "blade.tip"
component = "x"
[signals.flap]
kind = "deflection"
at = "blade.tip"
component = "z"
"""
WEIGHT = "gravity = [0.0, 0.0, -0.3]\n"


def test_run_that_starts_in_steady_spin_stays_steady(tmp_path):
    """Bent by weight along the axis and lifted by the spin: nothing moves in turning axes."""
    blade_beside(tmp_path, [{"kind": "bending-xz", "count": 2}])
    text = (
        CASE.format(hub=0.5)
        .replace("speed = 1.0", "speed = 6.0")
        .replace("blade.v", "sample/blade.v")
    )
    _, found, _ = run_text(tmp_path, WEIGHT + text + SIGNALS, t_end=2.0, step=0.1, more=STEADY)
    sag = found["flap"]
    assert sag[0] < -1e-3
    np.testing.assert_allclose(sag, sag[0], rtol=1e-7)
    np.testing.assert_allclose(found["stretch"], found["stretch"][0], rtol=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("speed = 1.0", "speed = 5.0", "solver.spin.speed = 6 rad/s: axis .* has another rate"),
        ("speed = 1.0", "speed = 6.0", "loads are not constant in axes that turn"),
        ("axis = [0.0, 0.0, 1.0]\n", "axis = [0.0, 1.0, 0.0]\n", "joint axis.* does not let"),
        (
            'kind = "package"',
            'kind = "package"\nmodal_rates = { "1" = 1.0 }',
            "expected no velocity",
        ),
    ],
)
def test_starts_that_cannot_be_steady(tmp_path, old, new, words):
    blade_beside(tmp_path, [{"kind": "bending-xz", "count": 2}])
    text = CASE.format(hub=0.5).replace("blade.v", "sample/blade.v").replace(old, new)
    across = "gravity = [0.0, -0.3, -0.3]\n" if "not constant" in words else ""
    with pytest.raises(InputError, match=words):
        run_text(tmp_path, across + text, t_end=1.0, step=0.1, more=STEADY)
