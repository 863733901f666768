"""Beams that are curved, twisted or tapered at rest: exact frequencies, published statics."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import scipy.special
from samples.beam_samples import CLAMPED, coupled_stiffness, reduced
from samples.curved_samples import BAR, meshed

from plymotion.preprocess.beam.beam_body import mesh_error, stiffness_error
from plymotion.preprocess.beam.line import LineSection, SectionMass
from plymotion.preprocess.beam.sections import StationSection
from plymotion.solver.inputs.case.bodies.beams import line_of
from plymotion.solver.inputs.case.tables.beam_keys import BeamBody
from plymotion.solver.math.rotations import matrix_to_vector, skew, vector_to_matrix

K = np.diag([4e3, 1e3, 1.2e3, 20.0, 30.0, 25.0])
MASS = SectionMass(1.0, np.array([0.0, 0.02, -0.01]), np.diag([0.03, 0.018, 0.012])).matrix()


def exact_frequencies(
    k: np.ndarray, length: float, K: np.ndarray, mass: np.ndarray, near: np.ndarray
) -> np.ndarray:
    """Clamped-free frequencies of a beam with constant curvatures k about its section axes.

    In these axes the equations u' + k x u + e1 x f = gamma, f' + k x f = kappa,
    F' + k x F = -w^2 p, M' + k x M + e1 x F = -w^2 l have constant coefficients. The roots next to
    the values `near` are returned.
    """
    e1 = skew(np.array([1.0, 0.0, 0.0]))
    turn = skew(k)
    motion = -np.block([[turn, e1], [np.zeros((3, 3)), turn]])
    forces = -np.block([[turn, np.zeros((3, 3))], [e1, turn]])
    # unknowns of the size of displacements: scaled, so that the exponential has even entries
    scale = np.concatenate([np.ones(6), np.sqrt(np.diag(K))])

    def determinant(w: float) -> float:
        A = np.block([[motion, np.linalg.inv(K)], [-(w**2) * mass, forces]])
        T = scipy.linalg.expm(length * A * scale[None] / scale[:, None])
        return float(np.linalg.det(T[6:, 6:]))

    return np.array(
        [scipy.optimize.brentq(determinant, 0.98 * w, 1.02 * w, xtol=1e-12 * w) for w in near]
    )


ARC = {"length": 1.5, "line": {"arc_deg": 70.0, "axis": [0.0, -0.6, 0.8]}}
TWISTED = {"length": 1.5, "twist_deg": [[0.0, 0.0], [1.0, 80.0]]}
HELIX_K = np.array([0.9, 0.5, -0.7])


def helix(elements: int) -> dict[str, Any]:
    """Constant curvatures about all three axes: given as nodes."""
    step, R, r = 1.5 / elements, np.eye(3), np.zeros(3)
    nodes, axes = [r], []
    for _ in range(elements):
        fine = vector_to_matrix(step / 200 * HELIX_K)
        for i in range(200):
            if i == 100:
                axes.append(R[:, 1])
            half = vector_to_matrix(step / 400 * HELIX_K)
            r = r + step / 200 * (R @ half)[:, 0]
            R = R @ fine
        nodes.append(r)
    return {"line": {"nodes": [n.tolist() for n in nodes], "x2_axes": [a.tolist() for a in axes]}}


@pytest.mark.parametrize("kind", ["arc", "twisted", "helix"])
def test_frequencies_are_those_of_the_exact_curved_beam(kind: str) -> None:
    """Couplings of all kinds, mass centre off the line; the error falls with h^2."""
    stiffness = coupled_stiffness(K)
    errors = []
    for elements in (16, 32):
        if kind == "arc":
            keys, k = ARC, np.radians(70.0) / 1.5 * np.array([0.0, -0.6, 0.8])
        elif kind == "twisted":
            keys, k = TWISTED, np.array([np.radians(80.0) / 1.5, 0.0, 0.0])
        else:
            keys, k = helix(elements), HELIX_K
        entries = meshed(elements, **keys)
        five = [{"kind": "lowest", "count": 5}]
        beam = reduced(CLAMPED, five, K=stiffness, mass=MASS, **{**entries, "elements": elements})
        found = beam.package.frequencies
        exact = exact_frequencies(k, 1.5, stiffness, MASS, found)
        errors.append(np.abs(found / exact - 1.0).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize(("direction", "published"), [("along", 5.424e-3), ("across", 1.754e-3)])
def test_twisted_cantilever_of_macneal_and_harder(direction: str, published: float) -> None:
    """Finite Elements in Analysis and Design 1 (1985): a beam twisted by 90 degrees."""
    L, b, t, E, nu = 12.0, 1.1, 0.32, 29e6, 0.22
    G, A, I2, I3 = E / 2 / (1 + nu), b * t, b * t**3 / 12, t * b**3 / 12
    J = b * t**3 / 3 * (1 - 0.63 * t / b)
    stiffness = np.diag([E * A, 5 / 6 * G * A, 5 / 6 * G * A, G * J, E * I2, E * I3])
    entries = meshed(48, length=L, twist_deg=[[0.0, 0.0], [1.0, 90.0]])
    loads = [{"kind": "attachment", "at": "tip", "directions": ["y", "z"]}]
    beam = reduced(CLAMPED, loads, K=stiffness, **{**entries, "elements": 48})
    tip = beam.interface("tip")
    flexibility = tip.phi_B @ np.linalg.solve(beam.package.stiffness, tip.phi_B.T)
    # at the tip the width is along z: a force along it, and one across
    found = flexibility[2, 2] if direction == "along" else flexibility[1, 1]
    assert found == pytest.approx(published, rel=5e-3)


def test_wedge_has_kirchhoffs_frequencies() -> None:
    """Thickness from h to nearly 0: J1(z) I2(z) + I1(z) J2(z) = 0, w = z^2 / 4 sqrt(EI / m L^4)."""

    def equation(z: float) -> float:
        J = [scipy.special.jv(order, z) for order in (1, 2)]
        modified = [scipy.special.iv(order, z) for order in (1, 2)]
        return float(J[0] * modified[1] + modified[0] * J[1])

    roots = [scipy.optimize.brentq(equation, a, b) for a, b in ((4.0, 5.0), (7.0, 8.5))]
    places = np.linspace(0.0, 1.0, 61)
    sections = []
    for at in places:
        h = max(1.0 - at, 1e-3)
        stiffness = np.diag([1e8 * h, 1e8 * h, 1e8 * h, h**3, h**3, 1e4 * h])
        mass = SectionMass(h, np.zeros(3), 1e-9 * h * np.diag([2.0, 1.0, 1.0])).matrix()
        sections.append(LineSection(stiffness, mass))
    stations = [{"at": float(at), "section": {}} for at in places]
    two = [{"kind": "bending-xz", "count": 2}]
    beam = reduced(CLAMPED, two, elements=60, sections=sections, stations=stations)
    np.testing.assert_allclose(beam.package.frequencies, np.square(roots) / 4.0, rtol=4e-3)


def test_estimated_mesh_error_of_a_tapered_beam_is_the_true_one() -> None:
    """Elements have the sections of their middles: an error of second order, too soft or stiff."""
    sections = [LineSection(K, MASS), LineSection(0.2 * K, 0.4 * MASS)]
    entries = {"sections": sections, "stations": [{"at": a, "section": {}} for a in (0.0, 1.0)]}
    asked = [{"kind": "lowest", "count": 4}]
    true = reduced(CLAMPED, asked, elements=64, **entries).package.frequencies
    for elements in (4, 8):
        beam = reduced(CLAMPED, asked, elements=elements, **entries)
        estimate = mesh_error(beam.model, beam.modes)
        np.testing.assert_allclose(estimate, beam.package.frequencies / true - 1.0, rtol=0.3)


def test_stiffness_error_has_those_of_the_section_and_of_the_mesh() -> None:
    """A section that is too stiff by 1e-3, in four elements."""
    coupled, asked = coupled_stiffness(K), [{"kind": "lowest", "count": 3}]
    coarse, fine = (reduced(CLAMPED, asked, elements=n, K=coupled) for n in (4, 32))
    section = StationSection(LineSection(coupled, MASS), None, 0, (), error=1e-3 * coupled)
    error = stiffness_error(coarse.model, coarse.modes, [section.stiffer()])
    too_high = np.diag(coarse.package.stiffness) / np.diag(fine.package.stiffness) - 1.0
    assert too_high.max() > 5e-3
    share = np.diag(error) / np.diag(coarse.package.stiffness)
    np.testing.assert_allclose(share, 1e-3 + too_high, rtol=0.2)
    np.testing.assert_allclose(error - np.diag(np.diag(error)), 0.0, atol=1e-9)


def test_tapered_beam_has_sections_at_all_nodes() -> None:
    """Linear between the stations; the resultants of a node belong to its section."""
    sections = [LineSection(K, MASS), LineSection(3.0 * K, 2.0 * MASS)]
    stations = [{"at": 0.0, "section": {}}, {"at": 1.0, "section": {}}]
    beam = reduced(
        CLAMPED, [{"kind": "lowest", "count": 4}], elements=4, sections=sections, stations=stations
    )
    package = beam.package
    assert [s.name for s in package.sections] == ["0001 bar", "0002", "0003", "0004", "0005 bar"]
    np.testing.assert_allclose(package.sections[2].K, 2.0 * K, rtol=1e-14)
    np.testing.assert_allclose(package.sections[1].M, 1.25 * MASS, rtol=1e-14)
    assert package.recovery.section.tolist() == [0, 1, 2, 3, 4]
    assert package.invariants.mass == pytest.approx(1.5, rel=1e-12)


def test_tip_of_a_curved_and_twisted_beam_to_second_order() -> None:
    """The strains of the modes, integrated along an exact beam: the error falls eightfold."""
    elements = 4
    entries = {**meshed(elements, **helix(elements)), "elements": elements}
    six = [{"kind": "lowest", "count": 6}]
    beam = reduced(CLAMPED, six, K=coupled_stiffness(K), mass=MASS, **entries)
    tip, line = beam.interface("tip"), beam.model.line
    direction = np.random.default_rng(1).normal(size=6)

    def exact(q: np.ndarray, steps: int = 300) -> np.ndarray:
        nodal = line.to_element(beam.modes.columns_B @ q[:, None])[..., 0]
        r, R = np.zeros(3), np.eye(3)
        of = {int(n): span.element for span in line.spans for n in span.numbers}
        for number, values in enumerate(nodal):
            A, element = line.A_BE[number], of[number]
            step = element.length / steps
            for strain in element.strain((np.arange(steps) + 0.5) * step) @ values:
                half = A @ vector_to_matrix(0.5 * step * strain[3:]) @ A.T
                r = r + step * R @ half @ A @ (np.array([1.0, 0.0, 0.0]) + strain[:3])
                R = R @ half @ half
        return np.concatenate([r, matrix_to_vector(R)])

    errors = []
    for size in (4e-3, 2e-3):
        q = size * direction
        first = np.concatenate([tip.position_B + tip.phi_B @ q, tip.psi_B @ q])
        H = np.concatenate([tip.H_B, tip.H_psi_B])
        two = first + 0.5 * np.einsum("aij,i,j->a", H, q, q)
        errors.append(np.abs(exact(q) - two).reshape(2, 3).max(axis=1))
        assert (errors[-1] < 0.1 * np.abs(two - first).max()).all()
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 3.0, atol=0.15)


def test_lines_run_where_they_are_described() -> None:
    """A spline through points of a circle, and the arc itself: places, length, axes."""
    angle = np.linspace(0.0, np.pi / 2, 17)
    points = np.column_stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle])
    splined = line_of(
        BeamBody.model_validate({**BAR, "line": {"points": points.tolist()}, "twist_deg": TWIST})
    )
    arc = line_of(
        BeamBody.model_validate(
            {**BAR, "length": np.pi / 2, "line": {"arc_deg": 90.0}, "twist_deg": TWIST}
        )
    )
    assert splined.length == pytest.approx(np.pi / 2, rel=1e-5)
    s = np.array([0.0, 0.3, 0.77, 1.0])
    np.testing.assert_allclose(arc.place(s)[-1], [1.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(splined.place(s), arc.place(s), atol=2e-5)
    np.testing.assert_allclose(splined.x2(s), arc.x2(s), atol=2e-3)
    np.testing.assert_allclose(arc.x2(s)[0], [0.0, 1.0, 0.0], atol=1e-15)
    # a quarter turn of the arc takes y to -x, half of the twist is 20 deg about the tangent
    half = np.radians(45.0)
    inward = np.array([-np.sin(half), np.cos(half), 0.0])
    expected = np.cos(np.radians(20.0)) * inward + np.sin(np.radians(20.0)) * np.array([0, 0, 1])
    np.testing.assert_allclose(arc.x2(np.array([0.5]))[0], expected, atol=1e-14)


TWIST = [[0.0, 0.0], [1.0, 40.0]]
