"""Frequencies of a prebent, twisted, tapered blade with couplings, by two routes.

The other route has no elements: the linear equations of the rod, u' = gamma + f x t, f' = kappa,
F' = -w2 p, M' = -w2 l - t x F in body axes, are integrated along the spline, and the determinant of
the free end vanishes at a frequency.
"""

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from beam_samples import dense
from beam_tables import write_table

from plymotion.preprocess.beam.body import beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.given import given_section
from plymotion.preprocess.beam.spec import read_spec
from plymotion.solver.inputs.case.beam_lines import line_of
from plymotion.solver.inputs.case.beams import beam_spec
from plymotion.solver.inputs.case.laws import FOLDER
from plymotion.solver.inputs.case.schema import Mechanism
from plymotion.solver.inputs.case.splines import Spline
from plymotion.solver.math.rotations import skew
from plymotion.solver.package.body.schema import SectionData

STEPS = 600


def blade(folder, elements):
    body = {
        "kind": "beam",
        "table": "beam.csv",
        "elements": elements,
        "modes": [{"kind": "lowest", "count": 5}],
        "interfaces": {"root": {"at": "start"}},
        "reference": {"kind": "clamped", "at": "root"},
    }
    table = {"bodies": {"blade": body}, "solver": {"t_end": 1.0, "output_step": 0.1}}
    return Mechanism.model_validate(table, context={FOLDER: folder})


def package(mechanism, folder):
    spec, _ = beam_spec("blade", mechanism.bodies["blade"], mechanism, folder)
    beam = read_spec(dict(spec))
    sections = [given_section(table) for table in beam.sections]
    model = beam_model(beam, *(section.line for section in sections))
    modes = beam_modes(model, dense)
    return beam_package(
        model, modes, [SectionData("s", s.line.K, s.line.mass) for s in sections], {}
    )


def exact(body, near):
    """Clamped-free frequencies next to `near` [rad/s], and the mass [kg]."""
    points = np.array(body.line.points)
    spline, line = Spline(points), line_of(body)
    at = np.array([station.at for station in body.stations])
    s = (np.arange(STEPS) + 0.5) / STEPS
    t = spline.tangent(s)
    x2 = line.x2(s)
    R = np.stack([t, x2, np.cross(t, x2)], axis=2)
    tables = [np.array([getattr(x, key) for x in body.stations]) for key in ("stiffness", "mass")]
    K, M = (
        np.array([[np.interp(s, at, A[:, i, j]) for j in range(6)] for i in range(6)])
        for A in tables
    )
    h = spline.length / STEPS
    T = np.zeros((STEPS, 6, 6))
    T[:, :3, :3] = T[:, 3:, 3:] = R
    S_B = T @ np.linalg.inv(np.moveaxis(K, 2, 0)) @ T.swapaxes(1, 2)
    M_B = T @ np.moveaxis(M, 2, 0) @ T.swapaxes(1, 2)
    size = np.sqrt(np.diag(K[..., 0]))
    scale = np.concatenate([np.ones(6), size])  # unknowns of even size
    across = np.array([skew(e) for e in t])

    def determinant(w):
        state = np.eye(12)[:, 6:]
        for k in range(STEPS):
            A = np.zeros((12, 12))
            A[:3, 3:6], A[9:, 6:9] = -across[k], -across[k]
            A[:6, 6:], A[6:, :6] = S_B[k], -(w**2) * M_B[k]
            state = scipy.linalg.expm(h * A * scale[None] / scale[:, None]) @ state
        return float(np.linalg.det(state[6:]))

    roots = [scipy.optimize.brentq(determinant, 0.97 * w, 1.03 * w, rtol=1e-9) for w in near]
    return np.array(roots), h * float(M[0, 0].sum())


def test_frequencies_of_a_table_are_those_of_the_rod(tmp_path):
    """The error of the elements falls with the square of their length."""
    write_table(tmp_path / "beam.csv")
    errors = []
    for elements in (32, 64):
        mechanism = blade(tmp_path, elements)
        found = package(mechanism, tmp_path)
        w, mass = exact(mechanism.bodies["blade"], found.frequencies[:4])
        errors.append(np.abs(found.frequencies[:4] / w - 1.0).max())
        assert found.invariants.mass == pytest.approx(mass, rel=2e-3)
    assert errors[1] < 1e-3
    assert errors[1] < 0.4 * errors[0]
