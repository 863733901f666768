"""Quasi-static start: bodies begin in the shape that the loads at t = 0 call for."""

import numpy as np
import pytest
from beam_samples import clamped_file
from case_samples import run_text

from plymotion.solver.errors import InputError
from plymotion.solver.package.body.invariants import inertia_at_rest

ARM = """
gravity = [0.0, -9.81, 0.0]
[ground.root]
position = [0.0, 0.0, 0.0]
[bodies.beam]
kind = "package"
package = "beam.vtkhdf"
[joints.root]
kind = "{joint}"
between = ["ground.root", "beam.root"]
{more}
[signals.tip]
kind = "deflection"
at = "beam.tip"
component = "y"
[signals.moment]
kind = "reaction"
joint = "root"
quantity = "moment"
component = "z"
"""
ACCELERATION = 0.2  # [rad/s2], too small for a centrifugal effect
DRIVE = f"axis = [0.0, 0.0, 1.0]\ndrive = {{ polynomial = [0.0, 0.0, {0.5 * ACCELERATION}] }}"
QUASI = 'start = "quasi-static"'


@pytest.fixture
def beam(tmp_path):
    return clamped_file(tmp_path, 3)


def test_a_clamped_beam_under_its_weight_is_at_rest(beam, tmp_path):
    """The quasi-static shape of a mechanism at rest is that of static equilibrium."""
    text = ARM.format(joint="fixed", more="")
    _, found, _ = run_text(tmp_path, text, t_end=0.05, step=0.005, more=QUASI)
    p = beam.invariants.S_B[1] * -9.81
    tip = next(place for place in beam.interfaces if place.name == "tip")
    static = float(tip.phi_B[1] @ np.linalg.solve(beam.stiffness, p))
    np.testing.assert_allclose(found["tip"], static, rtol=1e-7)


def test_a_drive_with_acceleration_does_not_ring(beam, tmp_path):
    """The deflection and the moment of a drive that begins with an acceleration stay as they are.

    The moment is that of the rigid body: alpha times its moment of inertia about the root.
    """
    text = ARM.replace("-9.81", "0.0").format(joint="revolute", more=DRIVE)
    t_end = 4.0 * np.pi / float(beam.frequencies[0])
    _, sudden, _ = run_text(tmp_path, text, t_end=t_end, step=t_end / 50)
    _, gentle, _ = run_text(tmp_path, text, t_end=t_end, step=t_end / 50, more=QUASI)
    moment = ACCELERATION * float(inertia_at_rest(beam.invariants)[2, 2])
    np.testing.assert_allclose(np.abs(gentle["moment"][0]), moment, rtol=1e-4)
    assert np.ptp(gentle["tip"][:10]) < 0.05 * np.abs(gentle["tip"]).max()
    assert np.ptp(sudden["tip"]) > 1.5 * np.abs(gentle["tip"][0])


def test_loads_that_grow_with_the_deformation_are_told(beam, tmp_path):
    """A spin beyond the first frequency: no shape balances its loads."""
    w = float(beam.frequencies[0])
    more = f"axis = [0.0, 0.0, 1.0]\ndrive = {{ speed = {3.0 * w} }}"
    text = ARM.format(joint="revolute", more=more)
    with pytest.raises(InputError, match="the shape of beam does not converge"):
        run_text(tmp_path, text, t_end=0.01, step=0.001, more=QUASI)
