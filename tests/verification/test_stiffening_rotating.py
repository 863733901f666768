"""Frequencies of rotating beams: the solver's accelerations, linearised about steady spin."""

import numpy as np
import pytest
import scipy.linalg
from samples.beam_samples import CHORD, CLAMPED, NAMES, REFERENCES, reduced
from samples.stiffening_samples import rectangle, steady_spin

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.dynamics.evaluation.accelerations import derivative
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import flexible_body
from plymotion.solver.package import read_package

# Slender to the limit of a Bernoulli beam that cannot be stretched: EI = rhoA = L = 1.
K = np.diag([1e8, 1e8, 1e8, 1.0, 1.0, 1.0])
MASS = SectionMass(1.0, np.zeros(3), np.diag([2e-10, 1e-10, 1e-10])).matrix()


@pytest.fixture(scope="module")
def table(published):
    return published("rotating_beam")


@pytest.fixture(scope="module")
def blade(repository):
    return read_package(repository / "tests/packages/rotating-blade/blade.stiffened.vtkhdf")


def beam(modes):
    return reduced(CLAMPED, modes, elements=20, K=K, mass=MASS).package


def four(plane: str):
    """Four static shapes of a spinning beam, good for all speeds."""
    return beam([{"kind": f"spinning-{plane}", "count": 4}])


def first(package, spins, **options):
    return np.array([steady_spin(package, float(mu), **options)[0][0] for mu in spins])


def test_flap_of_four_modes(table):
    """Out of the plane of rotation: 3-D."""
    expected = table["no-hub"]
    found = first(four("xz"), expected["mu"])
    np.testing.assert_allclose(found, expected["flap_1"], rtol=table["tolerance"])


def test_flap_on_a_hub(table):
    expected = table["hub"]
    found = first(four("xz"), expected["mu"], hub=1.0)
    np.testing.assert_allclose(found, expected["flap_1"], rtol=table["tolerance"])


def test_chord_of_four_modes(table):
    """In the plane of rotation."""
    expected = table["no-hub"]
    found = first(four("xy"), expected["mu"])
    np.testing.assert_allclose(found, expected["chord_1"], rtol=table["tolerance"])


def test_spinning_shapes_in_a_chord_frame():
    """They are static shapes like others, in both planes."""
    modes = [{"kind": f"spinning-{plane}", "count": 3} for plane in ("xy", "xz")]
    package = reduced(CHORD, modes, elements=10, K=K, mass=MASS).package
    expected = {f"spinning-{plane} {k}" for plane in ("xy", "xz") for k in (1, 2, 3)}
    assert set(package.mode_labels) == expected
    assert set(package.mode_kinds) == {"attachment"}


def test_three_flap_modes_of_twelve_vibrations(table):
    """Vibrations at rest follow the layer at the root slowly."""
    expected = table["no-hub"]
    flap = beam([{"kind": "bending-xz", "count": 12}])
    for row, mu in enumerate(expected["mu"]):
        if mu not in (0, 4, 8, 12):
            continue
        found = steady_spin(flap, float(mu))[0]
        known = [expected[f"flap_{k}"][row] for k in (1, 2, 3)]
        np.testing.assert_allclose(found[:3], known, rtol=table["tolerance"])


def test_linear_flap_does_not_stiffen_and_linear_chord_is_unstable():
    stiff = first(four("xz"), [0, 6], stiffening=False)
    np.testing.assert_allclose(stiff, 3.516, rtol=1e-3)
    slow, _ = steady_spin(four("xy"), 3.4, stiffening=False)
    fast, _ = steady_spin(four("xy"), 3.6, stiffening=False)
    assert len(fast) == len(slow) - 1  # one pair has become real
    assert slow[0] < 1.0


def test_composite_blade_against_measured_flap_frequencies(blade, published):
    """A package of the preprocessor, its section analysed: Epps and Chandra (1996)."""
    expected = published("rotating_blade")
    for rpm, measured in zip(expected["rpm"], expected["flap_hz"], strict=True):
        values, columns = steady_spin(blade, rpm * np.pi / 30.0, hub=0.0635)
        flap = [k for k, label in enumerate(blade.mode_labels) if label.startswith("bending-xz")]
        share = np.abs(columns[flap]) ** 2
        is_flap = share.sum(axis=0) > 0.5 * (np.abs(columns) ** 2).sum(axis=0)
        found = values[is_flap][:4] / (2.0 * np.pi)
        gap = np.linalg.norm(found - measured) / np.linalg.norm(measured)
        assert gap < expected["tolerance"]
        assert np.abs(found / measured - 1.0).max() < 0.07  # of the first mode: see docs


def flat(width: float, height: float):
    """Stiffness and mass of a rectangle, `width` in the plane of rotation about z."""
    K, mass = rectangle(70e9, 0.3, 2700.0, width, height)
    return {"K": K, "mass": mass}


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize(("width", "height"), [(0.03, 0.004), (0.004, 0.03), (0.02, 0.02)])
def test_propeller_moment(width, height, mass_form):
    """Torsion of a spinning bar: w^2 = w0^2 + W^2 (E_y - E_z) / (E_y + E_z).

    The stiffness W^2 (E_y - E_z) is proportional to the mass, so all modes are exact on any mesh.
    """
    torsion = [{"kind": "torsion", "count": 4}]
    blade = reduced(CLAMPED, torsion, elements=6, mass_form=mass_form, **flat(width, height))
    (at_rest, _), (spinning, _) = (steady_spin(blade.package, w) for w in (0.0, 900.0))
    E_y, E_z = width**2, height**2
    expected = 900.0**2 * (E_y - E_z) / (E_y + E_z)
    np.testing.assert_allclose(spinning**2 - at_rest**2, expected, atol=1e-7 * at_rest[-1] ** 2)


@pytest.mark.parametrize("reference", REFERENCES, ids=NAMES)
def test_propeller_moment_of_a_free_bar_in_all_frames(reference):
    """All torsion modes of the mesh, so that every frame has the same motions.

    The free bar spins about z. Its motion is linearised with the rates of the frame.
    """
    spin, m = 900.0, 6
    torsion = [{"kind": "torsion", "count": m}]
    bar = reduced(reference, torsion, elements=6, **flat(0.03, 0.004)).package
    model = assemble_model([flexible_body("bar", bar, stiffening=True)], [], [])
    steady = np.zeros(2 * m + 3)  # q, w, q_d
    steady[m + 2] = spin

    def rate(x):
        y = np.zeros(model.n_pos + model.n_vel + 1)
        y[3], y[7 : 7 + m], y[10 + m : 13 + 2 * m] = 1.0, x[:m], x[m:]
        return np.concatenate([x[m + 3 :], derivative(model, 0.0, y)[10 + m : 13 + 2 * m]])

    def slope(e, step):
        return (rate(steady + step * e) - rate(steady - step * e)) / (2 * step)

    # rates enter as a polynomial of second degree: differences are exact for any step
    A = [slope(e, 1e-6 if i < m else 1.0) for i, e in enumerate(np.eye(2 * m + 3))]
    values = np.linalg.eigvals(np.array(A).T)
    found = np.sort(values.imag[values.imag > 1.0])[-m:]
    line = reduced(reference, torsion, elements=6, **flat(0.03, 0.004)).model.line
    twist = np.arange(3, 6 * line.n_node, 6)
    K, M = (
        P.toarray()[np.ix_(twist, twist)]
        for P in (line.stiffness(), line.mass_matrix("consistent"))
    )
    free = scipy.linalg.eigh(K, M, eigvals_only=True)[1:]
    expected = np.sqrt(free + spin**2 * (0.03**2 - 0.004**2) / (0.03**2 + 0.004**2))
    np.testing.assert_allclose(found, expected, rtol=1e-6)
