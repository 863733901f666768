r"""Time of a cross-section: against one factorisation of its matrix, in a batch, from a cold start.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" \
    benchmarks/section_speed.py [--json FILE]

Times are seconds of processor on one core, which other work on the machine disturbs least. What
is compared runs in turns, and medians are printed.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from samples.section_cases import section

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.factorisation import MINIMUM_DEGREE
from plymotion.preprocess.fenicsx.libraries import PETSc
from plymotion.preprocess.section.section_problem import SectionProblem
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.space.section_mesh import SectionMesh, section_mesh
from plymotion.preprocess.section.timoshenko import mass_matrix
from plymotion.preprocess.section.warping import pinned_dofs

BOX = "21_box_layup2"
DENSITY = {6_000: 1.0, 20_000: 1.85}  # of the elements, by number of unknowns
TARGET = {6_000: 3.5, 20_000: 2.5}  # at most, times one factorisation
BATCH = 50


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the numbers there")
    parser.add_argument("--repeats", type=int, default=15)
    options = parser.parse_args()
    found: dict[str, Any] = {"versions": fenicsx.versions()}
    print(", ".join(f"{name} {version}" for name, version in found["versions"].items()))
    print(f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    found["single"] = [single(size, options.repeats) for size in DENSITY]
    found["batch"] = batch(max(3, options.repeats // 3))
    found["cold start"] = cold_start()
    if options.json:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps(found, indent=1), encoding="utf-8")


def single(size: int, repeats: int) -> dict[str, Any]:
    """From a mesh in memory to K and M, against MUMPS on the same matrix."""
    spec = section(BOX, DENSITY[size])
    mesh = section_mesh(spec["mesh"], "benchmark")
    problem = SectionProblem(mesh, 2)
    C = layup(spec, mesh, problem.space, "benchmark").stiffness
    free = problem.space.pattern.without(pinned_dofs(problem.space))
    matrix = free.matrix(problem.space.E(C).data)
    rivals: dict[str, Callable[[], float]] = {
        "section": lambda: one_section(spec, replace(mesh, cells=replace(mesh.cells))),
        "MUMPS, default ordering": lambda: factorise(matrix, None),
        "MUMPS, our ordering": lambda: factorise(matrix, MINIMUM_DEGREE),
    }
    rounds = np.array([[warm(rival) for rival in rivals.values()] for _ in range(repeats)])
    seconds = dict(zip(rivals, np.median(rounds, axis=0).tolist(), strict=True))
    ratios = np.median(rounds[:, :1] / rounds[:, 1:], axis=0).tolist()
    print(f"one section of {problem.space.n_dof} dofs, median of {repeats}:")
    for name, value in seconds.items():
        print(f"  {name:24s} {1e3 * value:7.1f} ms")
    print(
        f"  ratio {ratios[0]:.2f} to MUMPS's default ordering (target {TARGET[size]}), "
        f"{ratios[1]:.2f} to ours\n"
    )
    return {"dofs": problem.space.n_dof, "seconds": seconds, "ratios": ratios}


def warm(rival: Callable[[], float]) -> float:
    """Time of the second of two runs: it finds the memory that the first one has fetched."""
    rival()
    return rival()


def one_section(spec: dict[str, Any], mesh: SectionMesh) -> float:
    """All that follows the mesh, with nothing kept from the time before."""
    begin = time.process_time()
    problem = SectionProblem(mesh, 2)
    lay = layup(spec, mesh, problem.space, "benchmark")
    problem.solve(lay.stiffness)
    mass_matrix(problem.space, lay.density)
    return time.process_time() - begin


def factorise(A: Any, ordering: int | None) -> float:
    """Symbolic and numeric Cholesky factorisation of a PETSc matrix that is there already."""
    index = PETSc.IntType
    csr = (A.indptr.astype(index), A.indices.astype(index), A.data)
    mat = PETSc.Mat().createAIJ(A.shape, csr=csr, comm=PETSc.COMM_SELF)
    mat.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    mat.setOption(PETSc.Mat.Option.SPD, True)
    begin = time.process_time()
    pc = PETSc.PC().create(comm=PETSc.COMM_SELF)
    pc.setOperators(mat)
    if ordering is not None:
        PETSc.Options()["benchmark_mat_mumps_icntl_7"] = ordering
        pc.setOptionsPrefix("benchmark_")
    pc.setType("cholesky")
    pc.setFactorSolverType("mumps")
    pc.setUp()
    return time.process_time() - begin


def batch(repeats: int) -> dict[str, Any]:
    """Many lay-ups on one mesh: per section, and where the time goes."""
    base = section(BOX)
    mesh = section_mesh(base["mesh"], "benchmark")
    problem = SectionProblem(mesh, 2)
    angles = np.random.default_rng(0).integers(-90, 91, (BATCH, len(base["regions"]), 6))
    specs = [
        section(BOX, angles=dict(zip(base["regions"], stacks.tolist(), strict=True)))
        for stacks in angles
    ]
    spent = dict.fromkeys(("lay-up", "assembly", "factorisation", "solves"), 0.0)

    def timed(part: str, work: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any) -> Any:
            begin = time.process_time()
            result = work(*arguments)
            spent[part] += time.process_time() - begin
            return result

        return run

    space, solver = problem.space, problem.solver_of(problem.space)
    space.E = timed("assembly", space.E)  # type: ignore[method-assign]
    solver.factorise = timed("factorisation", solver.factorise)
    solver.solve = timed("solves", solver.solve)

    def run() -> float:
        begin = time.process_time()
        for spec in specs:
            lay = timed("lay-up", layup)(spec, mesh, problem.space, "benchmark")
            problem.solve(timed("lay-up", lambda lay=lay: lay.stiffness)())
            mass_matrix(problem.space, lay.density)
        return (time.process_time() - begin) / BATCH

    run()
    spent |= dict.fromkeys(spent, 0.0)
    seconds = [run() for _ in range(repeats)]
    shares = {part: value / BATCH / sum(seconds) for part, value in spent.items()}
    shares["rest"] = 1.0 - sum(shares.values())
    median = float(np.median(seconds))
    print(f"batch of {BATCH} lay-ups on one mesh, {problem.space.n_dof} dofs, median of {repeats}:")
    print(f"  {1.0 / median:.1f} sections/s, {1e3 * median:.1f} ms each:", end=" ")
    print(", ".join(f"{part} {100 * share:.0f} %" for part, share in shares.items()) + "\n")
    return {"dofs": problem.space.n_dof, "per second": 1.0 / median, "shares": shares}


def cold_start() -> dict[str, float]:
    """A fresh process for one section, its file included; first with no compiled code on disk."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        spec = Path(folder, "box.json")
        spec.write_text(json.dumps(section(BOX)), encoding="utf-8")
        command = [sys.executable, "-m", "plymotion.preprocess", "section", str(spec), "--force"]
        environment = {**os.environ, "PLYMOTION_CACHE": folder}
        for name in ("nothing compiled", "second time"):
            begin = time.perf_counter(), _children()
            subprocess.run(command, check=True, capture_output=True, env=environment)
            wall, processor = time.perf_counter() - begin[0], _children() - begin[1]
            found[name] = wall
            print(f"cold start, {name}: {wall:.1f} s, {processor:.1f} s of processor")
    return found


def _children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
