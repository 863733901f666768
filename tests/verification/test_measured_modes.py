"""A body known from a modal test only, against the FE model that was 'measured'."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from samples.beam_samples import CLAMPED, MEAN_AXIS, Beam, reduced
from samples.flexible_samples import momenta, simulate, total_energy

from plymotion.solver.extras.measured_modes import measured_package
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import flexible_body
from plymotion.solver.package import ModalPackage
from plymotion.solver.package.body.invariants import free_body_mass, rigid_motions

EI, LINE_MASS = 25.0, 1.0
STIFFNESS = np.diag([4e5, 1e6, 1e6, 20.0, 2.0 * EI, EI])
MASS = LINE_MASS * np.diag([1.0, 1.0, 1.0, 4e-4, 1e-4, 3e-4])
POINTS = 33  # accelerometers, one on each node


def measured(beam: Beam, folder: Path, noise: float) -> ModalPackage:
    """Import what accelerometers along the beam see: displacements in y and z, with noise."""
    package, kind = beam.package, beam.package.reference_condition
    rng = np.random.default_rng(1)
    nodes = np.arange(len(package.nodes_B))
    assert len(nodes) == POINTS
    share = np.full(POINTS, LINE_MASS / (POINTS - 1))
    share[[0, -1]] *= 0.5
    rows = ["node,x,y,z,mass,Jxx"]
    rows += [
        f"{k},{package.nodes_B[k, 0]},0,0,{m},{4e-4 * m}" for k, m in zip(nodes, share, strict=True)
    ]
    (folder / "nodes.csv").write_text("\n".join(rows))
    modes = ""
    for i, shape in enumerate(package.shapes_B):
        seen = shape[nodes, 1:3]
        seen = seen * (1.0 + noise * rng.standard_normal(seen.shape))
        rows = ["node,uy,uz", *(f"{k},{v},{w}" for k, (v, w) in zip(nodes, seen, strict=True))]
        (folder / f"{i}.csv").write_text("\n".join(rows))
        hz = package.frequencies[i] / (2.0 * np.pi)
        modes += f'[[modes]]\nfrequency_hz = {hz}\nshape = "{i}.csv"\n'
    at = ', at = "root"' if kind == "clamped" else ""
    (folder / "test.toml").write_text(
        f'format = 1\nbody = "beam"\nnodes = "nodes.csv"\nreference = {{ kind = "{kind}"{at} }}\n'
        f"{modes}[interfaces]\nroot = {{ nodes = [0] }}\ntip = {{ nodes = [{nodes[-1]}] }}\n"
    )
    return measured_package(folder / "test.toml")


def frequencies_with_mass(package: ModalPackage, mass: float, *, free: bool) -> np.ndarray:
    """Elastic angular frequencies with a mass at the tip, frame held or free."""
    tip = package.interfaces[-1]
    motion = np.hstack([rigid_motions(tip.position_B[None])[0, :3], tip.phi_B])
    M = free_body_mass(package) + mass * motion.T @ motion
    K = np.zeros_like(M)
    K[6:, 6:] = package.stiffness
    moving = np.arange(0 if free else 6, len(M))
    M, K = (A[np.ix_(moving, moving)] for A in (M, K))
    shift = package.stiffness[0, 0]
    values = 1.0 / scipy.linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1] - shift
    return np.sqrt(values[6:] if free else values)


@pytest.mark.parametrize("free", [False, True])
def test_body_with_another_mass_at_its_tip(free: bool, tmp_path: Path) -> None:
    """The first two frequencies of the modified body, which nobody measured."""
    modes = [{"kind": "bending-xy", "count": 5}, {"kind": "bending-xz", "count": 2}]
    reference = MEAN_AXIS if free else CLAMPED
    beam = reduced(reference, modes, elements=32, K=STIFFNESS, mass=MASS)
    true = frequencies_with_mass(beam.package, 0.5, free=free)[:2]
    bare = frequencies_with_mass(beam.package, 0.0, free=free)[:2]
    found = frequencies_with_mass(measured(beam, tmp_path, 0.0), 0.5, free=free)[:2]
    assert found == pytest.approx(true, rel=5e-3)
    noisy = frequencies_with_mass(measured(beam, tmp_path, 0.02), 0.5, free=free)[:2]
    assert noisy == pytest.approx(true, rel=0.02)
    assert (bare / true > 1.05).all()


def test_measured_body_flies_freely(tmp_path: Path) -> None:
    modes = [{"kind": "bending-xy", "count": 2}, {"kind": "bending-xz", "count": 2}]
    beam = reduced(MEAN_AXIS, modes, elements=32, K=STIFFNESS, mass=MASS)
    package = measured(beam, tmp_path, 0.02)
    model = assemble_model([flexible_body("beam", package)], [], [])
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3] = 1.0
    y[7:11] = [0.01, -0.004, 0.003, 0.002]
    y[model.n_pos : model.n_pos + 6] = [0.1, 0.2, -0.1, 0.5, -2.0, 4.0]
    states = simulate(model, y, np.linspace(0.0, 0.3, 5), rtol=1e-10)
    energy = np.array([total_energy(model, state) for state in states])
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-8
    for history in zip(*(momenta(model, state) for state in states), strict=True):
        series = np.array(history)
        assert np.abs(series - series[0]).max() < 1e-8 * np.linalg.norm(series[0])
    assert np.ptp(states[:, 7]) > 5e-3
