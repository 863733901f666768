r"""Our sections beside published values, in one go; the tables of docs/sections-accuracy.md.

. build/fenicsx.env && PYTHONPATH=.:tests:benchmarks "$FENICSX_PYTHON" \
    benchmarks/section_peers.py [--write docs/sections-accuracy.md]

Values are those of tests/reference/sections. --write puts the tables between the two lines with
`peers` of the file instead of printing them. Codes that can be run are in benchmarks/arena.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
from samples.section_cases import reference, section
from shell_text import replace_between

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.space.section_mesh import section_mesh

REPEATS = 5

POUND, INCH = 4.448222, 0.0254
DIAGONAL = {"EA": (1, 1), "GA2": (2, 2), "GA3": (3, 3), "GJ": (4, 4), "EI2": (5, 5), "EI3": (6, 6)}
# Couplings that the sources name in their own order; their signs follow other axes.
NAMED = {"K_N_My": (1, 6), "K_Sy_T": (3, 4), "K_Sx_N": (1, 2), "K_Mx_T": (4, 5)}
BECAS = "diag_order_EA_GA2_GA3_GJ_EI2_EI3"
SOURCES = {  # of the SI tables: file, key of its published values, whose they are
    "02": ("ANBA4", BECAS),
    "06": ("BECAS", BECAS),
    "07": ("BECAS", BECAS),
    "08": ("BECAS", BECAS),
    "09a": ("BECAS", BECAS),
    "09b": ("BECAS", BECAS),
    "09c": ("BECAS", BECAS),
    "11": ("PreVABS and VABS", "K_prevabs"),
    "14": ("solid elements (OpenSG)", "K_nonzero"),
}


def solved(name: str) -> tuple[Any, float]:
    """The section, and the median time from mesh in memory to all of the analysis [s]."""
    spec = section(name)
    section_mesh(spec["mesh"], "benchmark")
    seconds = []
    for _ in range(REPEATS):
        start = time.process_time()
        found = analyse(spec, estimate=False)
        seconds.append(time.process_time() - start)
    return found, float(np.median(seconds))


def table(head: list[str], rows: list[list[object]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(str(cell) for cell in line) + " |" for line in lines]


def percent(ours: float, theirs: float) -> str:
    return f"{100 * (ours / theirs - 1):+.1f} %"


def boxes() -> list[str]:
    """NABSA and VABS, three digits, in lb and in."""
    unit = np.array([POUND] * 3 + [POUND * INCH] * 3)
    rows: list[list[object]] = []
    cost = []
    for name in ("20", "21", "22"):
        published = reference(name)["published"]
        found, seconds = solved(name)
        cost.append(f"{1e3 * seconds:.0f} ms")
        for entry, value in published["nabsa"].items():
            i, j = (n - 1 for n in place(entry))
            ours = abs(found.K[i, j]) * POUND / (unit[i] * unit[j])
            vabs = f"{published['vabs_2000'][entry]:.3g}"
            rows.append([name, entry, f"{ours:.4g}", f"{value:.3g}", vabs, percent(ours, value)])
    return [
        "### Composite boxes of the paper, against NABSA and VABS (Popescu and Hodges 2000)",
        "",
        f"In lb and in; {found.provenance['dofs']} unknowns, {', '.join(cost)}.",
        "",
        *table(["lay-up", "entry", "Plymotion", "NABSA", "VABS 2000", "to NABSA"], rows),
    ]


def place(entry: str) -> tuple[int, int]:
    """Row and column of an entry, from 1."""
    return DIAGONAL.get(entry) or NAMED.get(entry) or (int(entry[1]), int(entry[2]))


def published_entries(name: str, key: str) -> dict[str, float]:
    """Entries that a reference file quotes, by name."""
    published = reference(name)["published"]
    if key == BECAS:
        values = dict(zip(DIAGONAL, published[key], strict=True))
        return values | {entry: published[entry] for entry in NAMED if entry in published}
    if key == "K_nonzero":
        return dict(published[key])
    K = np.array(published[key])
    names = {place: entry for entry, place in DIAGONAL.items()}
    rows, columns = np.nonzero(np.triu(K))
    return {
        names.get((i + 1, j + 1), f"K{i + 1}{j + 1}"): float(K[i, j])
        for i, j in zip(rows, columns, strict=True)
    }


def others() -> list[str]:
    """BECAS, ANBA4, VABS and solid elements."""
    rows: list[list[object]] = []
    for name, (source, key) in SOURCES.items():
        found, seconds = solved(name)
        cells = []
        for entry, value in published_entries(name, key).items():
            i, j = place(entry)
            ours = abs(found.K[i - 1, j - 1])
            label = entry if entry in DIAGONAL else f"K{i}{j}"
            cells.append(f"{label} {value:.6g} ({percent(ours, abs(value))})")
        rows.append(
            [name, source, ", ".join(cells), found.provenance["dofs"], f"{1e3 * seconds:.0f}"]
        )
    head = ["section", "published by", "published value (Plymotion to it)", "unknowns", "ms"]
    return ["### Other published values", "", *table(head, rows)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", type=Path, help="file to write into")
    options = parser.parse_args()
    lines = [
        f"DOLFINx {fenicsx.versions()['dolfinx']}; milliseconds of processor on one core, "
        f"median of {REPEATS}, from mesh in memory to K, M and stress recovery.",
        "",
        *boxes(),
        "",
        *others(),
    ]
    if options.write:
        replace_between(options.write, "peers", lines)
    else:
        print("\n".join(lines))


if __name__ == "__main__":
    main()
