"""One large section, shell and solid on 1, 2 and 4 ranks of MPI: time, memory, differences.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/ranks.py [--repeats N]

Each rank runs `python -m plymotion.preprocess section|shell|body SPEC.json` as users do. Assembly
is all from the mesh in memory to the rows that MUMPS gets, with what ranks exchange for them; its
steps begin at the same time. Times are those of the processor, user and system: MPI waits busily,
so waiting for other ranks is part of them. The slowest, or largest, rank counts; the least of runs
in turns, because other work on the machine adds to all figures.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

RANKS = (1, 2, 4)
# Open MPI: waiting ranks let others have the core; no rank is bound to a busy one.
QUIET = {"OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}


def models(folder: Path) -> dict[str, dict[str, Any]]:
    """A laminated box, a plate of triangles and a bracket held at a bore."""
    from samples.section_cases import section
    from samples.shell_specs import plate
    from samples.solid_samples import ALUMINIUM, bracket, step_file

    step_file(folder / "bracket.step", bracket)
    bore = {"radius": 0.008, "point": [0.015, 0.02, 0.0], "direction": [0.0, 0.0, 1.0]}

    clamped = {"root": {"at": "left", "fixed": "all"}}
    load = {"a": {"tip": {"at": "right", "force": [0.0, 0.0, 1.0]}}}
    return {
        "section": section("21_box_layup2", 4.3),
        "shell": plate(223, 0.01, supports=clamped, loads=load),
        "body": {
            **{"body": "bracket", "kind": "solid", "damping_ratio": 0.0},
            "solid": {
                "mesh": {"file": str(folder / "bracket.step"), "size": 0.00215},
                "materials": {"alloy": ALUMINIUM},
                "regions": {"all": {"material": "alloy"}},
            },
            "reference": {"kind": "clamped", "at": "bore"},
            "modes": [{"kind": "lowest", "count": 20}],
            "interfaces": {"bore": {"bore": bore, "link": "rigid", "rotation_deg": [0.0] * 3}},
        },
    }


def as_rank(folder: Path, words: list[str]) -> int:
    """The command; its figures go into a file for each rank."""
    from plymotion.preprocess.__main__ import main
    from plymotion.preprocess.fenicsx import libraries
    from plymotion.preprocess.fenicsx.assembly import SolidSpace
    from plymotion.preprocess.fenicsx.team import Distribution
    from plymotion.preprocess.section.space.numbering import Pattern, Restriction
    from plymotion.preprocess.section.space.space import SectionSpace
    from plymotion.preprocess.shell.model.freedom import Freedom
    from plymotion.preprocess.shell.model.shell_problem import Assembly

    parts = libraries.dolfinx, libraries.PETSc  # loaded at their first use otherwise: not assembly
    assert all(parts)
    spent = [0.0]
    for owner, name in (
        *((SectionSpace, "__init__"), (Pattern, "__init__"), (SectionSpace, "E")),
        *((Restriction, "matrix"), (Assembly, "matrix"), (Freedom, "reduced")),
        *((SolidSpace, "__init__"), (SolidSpace, "matrix"), (Distribution, "matrix")),
    ):
        setattr(owner, name, timed(getattr(owner, name), spent))
    start = time.perf_counter()
    code = main(words)
    found = {
        "assembly": spent[0],
        "whole": sum(os.times()[:4]),  # with gmsh, which solids have in a process of its own
        "elapsed": time.perf_counter() - start,
        "MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }
    (folder / f"{os.getpid()}.json").write_text(json.dumps(found))
    return code


def timed(work: Callable[..., Any], spent: list[float]) -> Callable[..., Any]:
    """A function that adds its processor time to `spent`, and begins on all ranks together."""
    from plymotion.preprocess.fenicsx import libraries

    def run(*arguments: Any, **options: Any) -> Any:
        libraries.MPI.COMM_WORLD.Barrier()
        start = time.process_time()
        found = work(*arguments, **options)
        spent[0] += time.process_time() - start
        return found

    return run


def measured(n: int, words: list[str]) -> dict[str, float]:
    """The largest figures of the ranks of one run."""
    from harness.mpi_samples import of_ranks

    os.environ |= QUIET
    with tempfile.TemporaryDirectory() as folder:
        done = of_ranks(n, __file__, "--as-rank", folder, *words)
        if done.returncode:
            raise subprocess.CalledProcessError(done.returncode, words, stderr=done.stderr)
        found = [json.loads(file.read_text()) for file in Path(folder).glob("*.json")]
    return {name: max(one[name] for one in found) for name in found[0]}


def difference(kind: str, one: Path, other: Path) -> float:
    """Of K, scaled by its diagonal, the displacements or the frequencies, from one rank."""
    from plymotion.solver.package import read_package
    from plymotion.solver.package.section.section_file import read_section
    from plymotion.solver.package.shell.shell_file import read_shell

    if kind == "section":
        a, b = read_section(one).K, read_section(other).K
        size = np.sqrt(np.diag(a))
        return float(np.abs((b - a) / np.outer(size, size)).max())
    if kind == "body":
        a, b = read_package(one).frequencies, read_package(other).frequencies
        return float(np.abs(b / a - 1.0).max())
    u, v = (read_shell(file).cases.displacements_G for file in (one, other))
    return float(np.abs(v - u).max() / np.abs(u).max())


def main() -> None:
    if sys.argv[1:2] == ["--as-rank"]:
        sys.exit(as_rank(Path(sys.argv[2]), sys.argv[3:]))
    repeats = int(sys.argv[2]) if sys.argv[1:2] == ["--repeats"] else 3
    print(f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    print("| | ranks | assembly [s] | whole [s] | elapsed [s] | MB | difference |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, spec in models(folder).items():
            file = folder / f"{kind}.json"
            file.write_text(json.dumps(spec))
            runs: dict[int, list[dict[str, float]]] = {n: [] for n in RANKS}
            for _ in range(repeats):
                for n in RANKS:
                    out = ["--force", "--out-dir", str(folder / str(n))]
                    runs[n].append(measured(n, [kind, str(file), *out]))
            for n in RANKS:
                least = {k: min(r[k] for r in runs[n]) for k in runs[n][0]}
                results = (folder / str(i) / f"{kind}.vtkhdf" for i in (1, n))
                print(
                    f"| {kind} | {n} | {least['assembly']:.2f} | {least['whole']:.2f} | "
                    f"{least['elapsed']:.1f} | {least['MB']:.0f} | "
                    f"{difference(kind, *results):.0e} |",
                    flush=True,
                )
    print(f"\nload of the machine {os.getloadavg()[0]:.1f} afterwards")


if __name__ == "__main__":
    main()
