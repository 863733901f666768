"""Rank of the constraints: where singular values are cut, and what noise in shapes does not do."""

from dataclasses import replace

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, reduced
from samples.modes_samples import modes_at, rates

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.dynamics.analysis.rank import rank_of
from plymotion.solver.package import write_package

STIFFNESS = np.diag([1e5, 1e5, 1e5, 1.0, 1.0, 1.0])  # uncoupled: bends in one plane
MASS = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()


@pytest.mark.parametrize(
    ("s", "rank", "doubtful"),
    [
        ([1.0, 0.3, 0.1], 3, False),
        ([1.0, 0.3, 1e-16], 2, False),
        ([1.0, 0.3, 1e-8], 2, False),  # round-off in a shape
        ([1.0, 0.3, 1e-4], 3, False),  # a hinge that is tilted
        ([1.0, 0.3, 1e-4, 1e-12], 3, False),
        ([1.0, 0.3, 3e-6, 5e-7, 1e-16], 4, False),  # 1e-6 divides values of one size: the gap below
        ([1.0, 0.3, 3e-6, 5e-7], 2, False),  # the same: the gap above
        ([1.0, 0.3, 2e-5, 2e-6, 5e-7, 5e-8], 2, False),
        ([1.0, 1e-2, 2e-4, 5e-6, 4e-7, 3e-8, 2e-9, 1e-10], 2, True),  # no gap at all
    ],
)
def test_rank_is_cut_at_the_gap_near_1e_6(s, rank, doubtful):
    found = rank_of(np.array(s), len(s) + 2)
    assert found.value == rank
    assert found.redundant == len(s) + 2 - rank
    assert found.doubtful == doubtful
    assert found.last == s[rank - 1]
    assert found.first == (s[rank] if rank < len(s) else 0.0)


def test_no_rows_and_rows_of_zero():
    assert rank_of(np.zeros(0), 0).value == 0
    assert rank_of(np.zeros(2), 2).redundant == 2


GUIDED = """
[ground.root]
position = [0.0, 0.0, 0.0]
[ground.end]
position = [1.0, 0.0, 0.0]
[bodies.beam]
kind = "package"
package = "beam.vtkhdf"
[joints.root]
kind = "fixed"
between = ["ground.root", "beam.root"]
"""
GUIDE = """
[joints.guide]
kind = "point_on_line"
between = ["ground.end", "beam.tip"]
axis = [0.0, 0.0, 1.0]
"""


@pytest.mark.parametrize("noise", [0.0, 1e-8, 1e-7])
def test_noise_in_a_shape_does_not_lock_a_motion(tmp_path, capsys, noise):
    """A guide that repeats what the clamp holds; with noise its rows look independent."""
    modes = [{"kind": "bending-xz", "count": 3}]
    package = reduced(CLAMPED, modes, K=STIFFNESS, mass=MASS).package
    shift = noise * np.array([[0.7, -0.4, 0.5], [-0.9, 0.8, -0.2], [0.0, 0.0, 0.0]])
    noisy = tuple(
        replace(i, phi_B=i.phi_B + shift * np.abs(i.phi_B).max()) if i.name == "tip" else i
        for i in package.interfaces
    )
    (tmp_path / "sample").mkdir()
    write_package(tmp_path / "sample" / "beam.vtkhdf", replace(package, interfaces=noisy))
    free = modes_at(tmp_path, GUIDED, "start", capsys=capsys)
    guided = modes_at(tmp_path, GUIDED + GUIDE, "start", capsys=capsys)
    assert rates(free) == pytest.approx(package.frequencies, rel=1e-8)
    assert rates(guided) == pytest.approx(package.frequencies, rel=1e-6)
    assert guided["constraints"]["largest_dropped"] < 1e-6
