"""Natural frequencies of uniform beams against exact solutions of Timoshenko's equations.

The exact solution integrates the beam's own differential equations with inertia,

    d' = Z d + K^-1 F,    F' = Q F - w^2 m d,

over the whole length by one matrix exponential: no elements. A clamped-free beam
vibrates where the transfer matrix from its root forces to its tip forces is
singular. All couplings of K and m are in it.
"""

from collections.abc import Callable

import numpy as np
import pytest
import scipy.optimize
from samples.beam_samples import coupled_stiffness, dense, straight_line

from plymotion.preprocess.beam.beam_body import frequency_error
from plymotion.preprocess.beam.beam_stations import mass_stations
from plymotion.preprocess.beam.element import Q, Z
from plymotion.preprocess.beam.line import BeamLine
from plymotion.preprocess.modes.eigenmodes import KINDS, ModeRequest
from plymotion.preprocess.modes.reduced import Modes, reduced_modes
from plymotion.preprocess.modes.reference import HeldDofs

LENGTH = 0.5
E, NU, RHO, WIDTH, HEIGHT = 7e10, 0.3, 2700.0, 0.02, 0.05  # along x2, x3
G, AREA = E / (2 * (1 + NU)), WIDTH * HEIGHT
I2, I3 = WIDTH * HEIGHT**3 / 12, HEIGHT * WIDTH**3 / 12
ISOTROPIC = np.diag([E * AREA, 5 / 6 * G * AREA, 5 / 6 * G * AREA, G * 9.9e-8, E * I2, E * I3])
MASS = RHO * np.diag([AREA, AREA, AREA, I2 + I3, I2, I3])


def cantilever_modes(
    K: np.ndarray, elements: int, requests: list[ModeRequest], mass_form: str = "consistent"
) -> tuple[BeamLine, Modes]:
    line = straight_line(np.linspace(0, LENGTH, elements + 1), K, MASS, np.eye(3))

    def participation(columns: np.ndarray) -> np.ndarray:
        return mass_stations(line, columns, mass_form).participation()

    modes = reduced_modes(
        HeldDofs(line.stiffness(), line.mass_matrix(mass_form), np.arange(6)),
        requests,
        [],
        participation,
        np.arange(line.n_node)[::-1],
        dense,
    )
    return line, modes


# the strains and forces that take part in a kind of motion of an uncoupled beam
PART = {"bending-xy": [1, 5], "bending-xz": [2, 4], "torsion": [3], "axial": [0]}


def tip_force_determinant(K: np.ndarray, part: list[int]) -> Callable[[float], float]:
    """Determinant whose roots are the clamped-free angular frequencies."""
    S = np.linalg.inv(K)
    scale = np.sqrt(np.diag(K))

    def value(omega: float) -> float:
        A = np.zeros((12, 12))
        A[:6, :6], A[:6, 6:] = Z, S
        A[6:, :6], A[6:, 6:] = -(omega**2) * MASS, Q
        balance = np.concatenate([1 / scale, scale])
        A = A * np.outer(1 / balance, balance)
        tip_by_root = scipy.linalg.expm(A * LENGTH)[6:, 6:]
        return float(np.linalg.det(tip_by_root[np.ix_(part, part)]))

    return value


def exact_near(K: np.ndarray, guess: float, width: float, kind: str = "") -> float:
    """The exact frequency next to a guess; it must be the only one (of its kind) within `width`."""
    f = tip_force_determinant(K, PART.get(kind, list(range(6))))
    return float(
        scipy.optimize.brentq(f, guess * (1 - width), guess * (1 + width), xtol=1e-9, rtol=1e-14)
    )


def test_exact_solution_has_the_textbook_limit() -> None:
    # E. g. Blevins: clamped-free Bernoulli beam, 1.8751^2; made shear-stiff and slender here.
    K = ISOTROPIC.copy()
    K[1, 1] *= 1e6
    K[2, 2] *= 1e6
    textbook = 1.875104068711961**2 * np.sqrt(E * I3 / (RHO * AREA)) / LENGTH**2
    rotary = I3 / (AREA * LENGTH**2)  # what is left of Timoshenko, of this relative order
    assert exact_near(K, textbook, 0.02) == pytest.approx(textbook, rel=4 * rotary)
    axial = 0.5 * np.pi * np.sqrt(E / RHO) / LENGTH
    assert exact_near(ISOTROPIC, axial, 1e-3) == pytest.approx(axial, rel=1e-9)


@pytest.mark.parametrize("stiffness", ["isotropic", "coupled"])
def test_lowest_frequencies_converge_to_the_exact_ones(stiffness: str) -> None:
    K = ISOTROPIC if stiffness == "isotropic" else coupled_stiffness(ISOTROPIC)
    request = [ModeRequest("lowest", 4)]
    meshes = (8, 16, 32)
    found = np.array([np.sqrt(cantilever_modes(K, n, request)[1].values) for n in meshes])
    exact = np.array([exact_near(K, w, 5e-3) for w in found[-1]])
    error = found / exact - 1.0
    order = np.log2(error[:-1] / error[1:])
    assert (error > 0).all(), "consistent mass bounds frequencies from above"
    assert error[1].max() < 2e-3
    assert error[-1].max() < 5e-4
    assert (order > 1.9).all()


def test_bending_converges_with_the_fourth_order_where_it_is_slender() -> None:
    K = ISOTROPIC.copy()
    K[1, 1] *= 1e4  # shear and rotary inertia leave an error of second order, small and later
    _, coarse = cantilever_modes(K, 4, [ModeRequest("bending-xy", 2)])
    _, fine = cantilever_modes(K, 8, [ModeRequest("bending-xy", 2)])
    exact = np.array([exact_near(K, w, 5e-3) for w in np.sqrt(fine.values)])
    order = np.log2((np.sqrt(coarse.values) / exact - 1) / (np.sqrt(fine.values) / exact - 1))
    assert (order > 3.5).all()


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize("kind", KINDS)
def test_frequencies_of_each_kind(kind: str, mass_form: str) -> None:
    # bars: (k L)^2/24 = 2.5e-3 for the third mode; lumped bending loses rotary stations at the tip
    limits = {"consistent": 2.6e-3, "lumped": 1.2e-2}
    _, modes = cantilever_modes(ISOTROPIC, 32, [ModeRequest(kind, 3)], mass_form)
    assert modes.labels == tuple(f"{kind} {i}" for i in (1, 2, 3))
    for w in np.sqrt(modes.values):
        exact = exact_near(ISOTROPIC, w, 0.02, kind)
        assert w == pytest.approx(exact, rel=limits[mass_form])


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize("elements", [4, 8, 16])
def test_estimated_frequency_error_is_the_true_one(elements: int, mass_form: str) -> None:
    request = [ModeRequest(kind, 2) for kind in KINDS]
    line, modes = cantilever_modes(ISOTROPIC, elements, request, mass_form)
    estimate = frequency_error(line, modes.values, modes.columns_B, mass_form)
    _, fine = cantilever_modes(ISOTROPIC, 96, request)
    reference = dict(zip(fine.labels, np.sqrt(fine.values), strict=True))
    for label, w, guess in zip(modes.labels, np.sqrt(modes.values), estimate, strict=True):
        exact = exact_near(ISOTROPIC, reference[label], 2e-3, label.split()[0])
        true = w / exact - 1.0
        print(f"{label} {elements} {mass_form}: true {true:.2e}, estimated {guess:.2e}")
        assert 0.8 < guess / true < 1.25
