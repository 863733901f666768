"""Time of a modal analysis over that of its bare eigenvalue problem, for shells of 10 k triangles.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/shell_speed.py

Total: from a mesh in memory to eight checked modes (lay-ups, element matrices, assembly, supports,
SLEPc, the count by pivots). Bare: SLEPc's shift and invert about zero on the same two matrices,
MUMPS Cholesky with PETSc's defaults, tolerance 1e-8, nothing else. Seconds of processor, medians.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from samples.shell_cantilevers import box, cantilever

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.factorisation import sorted_csr
from plymotion.preprocess.fenicsx.libraries import MPI, SLEPc
from plymotion.preprocess.fenicsx.team import Distribution

N_MODE = 8
REPEATS = 7
SHELLS = {
    "cantilever plate, 10 080 triangles": lambda: cantilever((120, 42), "[45,45,0]s")[0],
    "box beam, 10 000 triangles": lambda: box((125, 12, 8), "cas15")[0],
}


def bare(K: Any, M: Any) -> float:
    """One solution by SLEPc, set up here; returns the lowest value."""
    eps = SLEPc.EPS().create(comm=MPI.COMM_SELF)
    rows = Distribution(fenicsx.ALONE, K, M)
    eps.setOperators(rows.matrix(K, spd=True), rows.matrix(M, spd=False))
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(0.0)
    eps.setDimensions(nev=N_MODE)
    eps.setTolerances(tol=1e-8)
    transformation = eps.getST()
    transformation.setType(SLEPc.ST.Type.SINVERT)
    ksp = transformation.getKSP()
    ksp.setType("preonly")
    ksp.getPC().setType("cholesky")
    if fenicsx.HAS_MUMPS:
        ksp.getPC().setFactorSolverType("mumps")
    eps.solve()
    if eps.getConverged() < N_MODE:
        raise RuntimeError("SLEPc found fewer modes than asked for")
    lowest = float(eps.getEigenvalue(0).real)
    eps.destroy()
    return lowest


def timed(work: Callable[[], Any]) -> float:
    """Median seconds of processor after one turn to warm up."""
    work()
    seconds = []
    for _ in range(REPEATS):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return float(np.median(seconds))


def main() -> None:
    print(f"DOLFINx {fenicsx.versions()['dolfinx']}, {N_MODE} modes, median of {REPEATS}")
    for title, make in SHELLS.items():
        model = make()
        model.frequencies = {"count": N_MODE}
        solved = model.solved()
        problem, freedom = solved.problem, solved.freedom
        K, M = (sorted_csr(freedom.reduced(matrix)) for matrix in (problem.K, problem.M))

        def matrices(model: Any = model) -> None:
            of = model.solved().problem
            of.freedom.reduced(of.K)
            of.freedom.reduced(of.M)

        alone = timed(lambda K=K, M=M: bare(K, M))
        total = timed(lambda model=model: model.solved().frequencies)
        made = timed(matrices)
        print(f"{title}, {freedom.n_free} unknowns: total {total:.3f} s, of which matrices")
        print(f"  {made:.3f} s; bare SLEPc {alone:.3f} s; ratio {total / alone:.2f}")


if __name__ == "__main__":
    main()
