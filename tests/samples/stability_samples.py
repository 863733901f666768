"""One flexible body of the repository on a joint, undamped, and runs of fixed steps.

The hand of the double pendulum, `isotropic`: reduced to four modes of its clamped frame, so that
welded to the ground it vibrates at exactly the package's frequencies.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from samples.mechanism_samples import GRAVITY, GROUND, Sample

from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.integrators.generic.base import Integrator
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, flexible_body
from plymotion.solver.package import read_package

HAND = Path(__file__).parents[1] / "packages/double-pendulum-limits/hand.isotropic-paper.vtkhdf"


def hand(
    joint: str, bent: Sequence[float] = (), gravity: bool = False
) -> tuple[Sample, np.ndarray]:
    """The hand on a joint of the ground about z, its first modes displaced by `bent`.

    The probe is its tip.

    Returns the sample and the undamped frequencies of the modes (4,) [rad/s].
    """
    package = read_package(HAND)
    package = replace(package, damping=np.zeros_like(package.damping))
    body = flexible_body("hand", package)
    m = package.n_mode
    farthest = int(np.argmax(np.linalg.norm(package.nodes_B, axis=1)))
    tip = package.nodes_B[farthest]
    markers = [
        MarkerTable(GROUND, np.zeros(3)),
        MarkerTable(0, np.zeros(3), phi=np.zeros((3, m)), psi=np.zeros((3, m))),
        MarkerTable(0, tip, phi=package.shapes_B[:, farthest, :3].T, psi=np.zeros((3, m))),
    ]
    model = assemble_model(
        [body],
        markers,
        [JointTable("foot", joint, 0, 1)],
        gravity_G=GRAVITY if gravity else (0.0, 0.0, 0.0),
    )
    positions = np.zeros(model.n_pos)
    positions[3] = 1.0
    positions[7 : 7 + len(bent)] = bent
    none = np.zeros(model.n_vel)
    sample = Sample(model, Start(positions, none, none.astype(bool)), ["foot"], 2)
    return sample, np.sqrt(np.diag(package.stiffness))


def stepped(integrator: Integrator, seen) -> np.ndarray:
    """`seen(integrator)` after each step to the end of the run, (k, ...)."""
    values = []
    while integrator.status == "running":
        before = integrator.counters.steps
        integrator.step()
        if integrator.counters.steps > before:
            values.append(seen(integrator))
    return np.array(values)


def amplitude(model: Model, mode: int, w: float):
    """Function (integrator) -> amplitude of a vibrating mode of the only body, of rate w."""
    q, q_d = 7 + mode, model.n_pos + 6 + mode
    return lambda integrator: float(np.hypot(integrator.y[q], integrator.y[q_d] / w))
