"""One large section and one large shell on 1, 2 and 4 ranks of MPI: time, memory, differences.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/ranks.py [--repeats N]

Each rank runs `python -m plymotion.preprocess section|shell SPEC.json` as users do, in a profile by
processor time. Assembly is all from the mesh in memory to the rows that MUMPS gets. Processor time
contains waiting for other ranks, because MPI waits busily. The slowest, or largest, rank counts;
the least of runs in turns, because other work on the machine adds to all figures.
"""

import cProfile
import json
import os
import pstats
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

RANKS = (1, 2, 4)
# Open MPI: waiting ranks let others have the core; no rank is bound to a busy one.
QUIET = {"OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}
ASSEMBLY = {  # functions whose time, with all that they call, is that of the assembly
    "section": (
        ("section/space.py", "__init__"),
        ("section/space.py", "pattern"),
        ("section/operators.py", "E"),
        ("section/pattern.py", "matrix"),
        ("fenicsx/distributed.py", "matrix"),
    ),
    "shell": (
        ("shell/problem.py", "K"),
        ("shell/freedom.py", "reduced"),
        ("fenicsx/distributed.py", "matrix"),
    ),
}


def models() -> dict[str, dict[str, Any]]:
    """A laminated box and a plate of triangles."""
    from section_cases import section
    from shell_specs import plate

    clamped = {"root": {"at": "left", "fixed": "all"}}
    load = {"a": {"tip": {"at": "right", "force": [0.0, 0.0, 1.0]}}}
    return {
        "section": section("21_box_layup2", 4.3),
        "shell": plate(223, 0.01, supports=clamped, loads=load),
    }


def as_rank(folder: Path, words: list[str]) -> int:
    """The command in a profile; its figures go into a file for each rank."""
    from plymotion.preprocess.__main__ import main

    profile, start = cProfile.Profile(time.process_time), time.perf_counter()
    code = profile.runcall(main, words)
    used = resource.getrusage(resource.RUSAGE_SELF)
    found = {
        "assembly": _assembly(profile, words[0]),
        "processor": used.ru_utime + used.ru_stime,
        "elapsed": time.perf_counter() - start,
        "MB": used.ru_maxrss / 1024.0,
    }
    (folder / f"{os.getpid()}.json").write_text(json.dumps(found))
    return code


def _assembly(profile: cProfile.Profile, kind: str) -> float:
    rows = pstats.Stats(profile).stats.items()  # type: ignore[attr-defined]
    return sum(
        row[3]
        for (file, _, name), row in rows
        if any(file.endswith(place) and name == own for place, own in ASSEMBLY[kind])
    )


def measured(n: int, words: list[str]) -> dict[str, float]:
    """The largest figures of the ranks of one run."""
    from mpi_samples import of_ranks

    os.environ |= QUIET
    with tempfile.TemporaryDirectory() as folder:
        done = of_ranks(n, __file__, "--as-rank", folder, *words)
        if done.returncode:
            raise subprocess.CalledProcessError(done.returncode, words, stderr=done.stderr)
        found = [json.loads(file.read_text()) for file in Path(folder).glob("*.json")]
    return {name: max(one[name] for one in found) for name in found[0]}


def difference(kind: str, one: Path, other: Path) -> float:
    """Of K, scaled by its diagonal, or of the displacements, from those of one rank."""
    from plymotion.solver.package.section.io import read_section
    from plymotion.solver.package.shell.io import read_shell

    if kind == "section":
        a, b = read_section(one).K, read_section(other).K
        size = np.sqrt(np.diag(a))
        return float(np.abs((b - a) / np.outer(size, size)).max())
    u, v = (read_shell(file).cases.displacements_G for file in (one, other))
    return float(np.abs(v - u).max() / np.abs(u).max())


def main() -> None:
    if sys.argv[1:2] == ["--as-rank"]:
        sys.exit(as_rank(Path(sys.argv[2]), sys.argv[3:]))
    repeats = int(sys.argv[2]) if sys.argv[1:2] == ["--repeats"] else 3
    print(f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    print("| | ranks | assembly [s] | whole, processor [s] | elapsed [s] | MB | difference |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, spec in models().items():
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
                    f"| {kind} | {n} | {least['assembly']:.2f} | {least['processor']:.2f} | "
                    f"{least['elapsed']:.1f} | {least['MB']:.0f} | "
                    f"{difference(kind, *results):.0e} |",
                    flush=True,
                )
    print(f"\nload of the machine {os.getloadavg()[0]:.1f} afterwards")


if __name__ == "__main__":
    main()
