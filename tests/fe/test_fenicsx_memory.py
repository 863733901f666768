"""Memory of PETSc and SLEPc factors is freed: a batch of bodies must not fill the memory."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from samples.section_cases import section

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.section_analysis import analyse

STATM = Path("/proc/self/statm")


def _resident() -> float:
    """Memory of this process [MB]."""
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def _grid(n: int) -> sp.csr_matrix:
    """Laplacian of a square of n x n points."""
    line = sp.diags([-1.0, 2.1, -1.0], [-1, 0, 1], shape=(n, n))
    return sp.csr_matrix(sp.kron(line, sp.identity(n)) + sp.kron(sp.identity(n), line))


pytestmark = pytest.mark.skipif(
    not STATM.exists(), reason="the memory of a process is read from /proc"
)


def test_factors_are_given_back() -> None:
    K = _grid(70)
    M = sp.identity(K.shape[0], format="csr")

    def once() -> None:
        fenicsx.eigenpairs(K, M, 4)
        fenicsx.negative_pivots(K - 1e-3 * M)
        factor = fenicsx.Cholesky(K)
        factor.solve(np.ones(K.shape[0]))
        factor.close()
        dropped = fenicsx.cholesky(K)
        dropped.update(2.0 * K)
        dropped.solve(np.ones((K.shape[0], 6)))

    once()
    once()
    before = _resident()
    for _ in range(3):
        once()
    assert _resident() - before < 4.0  # those of `dropped` alone are 3 each time


@pytest.mark.one_end
def test_refined_sections_are_given_back() -> None:
    def once() -> int:
        return len(analyse(section("21", 0.5), accuracy=1e-4).provenance["refinements"])

    assert once() > 1
    before = _resident()
    once()
    once()
    assert _resident() - before < 100.0  # kept, they are 150 each time on DOLFINx 0.5.2


NEW_SECTIONS = """
import resource
from dataclasses import replace
from samples.section_cases import section
from plymotion.preprocess.section.section_problem import SectionProblem
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.space.section_mesh import section_mesh

spec = section("21_box_layup2")
mesh = section_mesh(spec["mesh"], "section")
for number in range(13):
    if number == 5:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    problem = SectionProblem(replace(mesh, cells=replace(mesh.cells)), 2)
    problem.solve(layup(spec, mesh, problem.space, "section").stiffness)
print((resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before) / 8)
"""


def test_freed_memory_serves_the_next_section() -> None:
    """Without `keep_memory`, a new section gets 2300 pages from the system with DOLFINx 0.11."""
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
    command = [sys.executable, "-c", NEW_SECTIONS]
    done = subprocess.run(command, env=paths, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 600.0
