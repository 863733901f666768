r"""Our sections beside those of others, in one go; the tables of docs/sections-accuracy.md.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" \
    benchmarks/section_peers.py [--peer PEER_PYTHON] [--write docs/sections-accuracy.md]

PEER_PYTHON is an interpreter with `sectionproperties` (python3 -m venv build/peers;
build/peers/bin/pip install sectionproperties); without it that table says so. The other tables
compare with the published values of tests/reference/sections. --write puts the tables between the
two lines with `peers` of the file instead of printing them.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import argparse
import json
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
from samples.section_cases import reference, section

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.analysis import analyse
from plymotion.preprocess.section.space.mesh import section_mesh

HERE = Path(__file__).resolve().parent
REPEATS = 5
BEGIN, END = "<!-- peers: begin -->", "<!-- peers: end -->"

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


def sectionproperties(python: str | None) -> list[str]:
    """Isotropic sections: torsion constant, shear areas, shear centre, and times."""
    title = "### sectionproperties, isotropic sections"
    if python is None:
        return [title, "", "Not compared: no interpreter with sectionproperties was given."]
    script = str(HERE / "section_peer_sectionproperties.py")
    done = subprocess.run([python, script], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"sectionproperties did not run: {done.stderr.strip().splitlines()[-1]}")
    theirs = json.loads(done.stdout)
    rows: list[list[object]] = []
    for name, peer in theirs["sections"].items():
        E, nu = (reference(name)["material"][key] for key in ("E", "nu"))
        found, seconds = solved(name)
        G, S, area = 0.5 * E / (1.0 + nu), np.linalg.inv(found.K), found.K[0, 0] / E
        # about the shear centre, where shear and torsion part
        Z = S[1:3, 1:3] - np.outer(S[1:3, 3], S[3, 1:3]) / S[3, 3]
        ours = {
            "J": 1.0 / S[3, 3] / G,
            "shear": 1.0 / np.diag(Z) / (G * area),
            "shear_centre": found.shear_centre,
            "unknowns": found.provenance["dofs"],
            "seconds": seconds,
        }
        for title_of, values in ((f"{name} Plymotion", ours), ("sectionproperties", peer)):
            size = np.sqrt(area)
            centre = [0.0 if abs(x) < 1e-5 * size else x for x in values["shear_centre"]]
            rows.append(
                [
                    title_of,
                    f"{values['J']:.6g}",
                    *(f"{share:.5f}" for share in values["shear"]),
                    ", ".join(f"{x:.5g}" for x in centre),
                    values["unknowns"],
                    f"{1e3 * values['seconds']:.0f}",
                ]
            )
    head = ["section", "J", "A2 / A", "A3 / A", "shear centre", "unknowns", "ms"]
    return [f"{title} (version {theirs['version']})", "", *table(head, rows)]


def write(path: Path, lines: list[str]) -> None:
    """Put the lines between the marks of a file."""
    text = path.read_text(encoding="utf-8")
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        raise SystemExit(f"{path}: expected one line {BEGIN} and one {END}")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    part = path.with_name(f"{path.name}.part")
    part.write_text(before + "\n\n".join([BEGIN, "\n".join(lines), END]) + after, encoding="utf-8")
    part.replace(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer", help="interpreter with sectionproperties")
    parser.add_argument("--write", type=Path, help="file to write into")
    options = parser.parse_args()
    lines = [
        f"DOLFINx {fenicsx.versions()['dolfinx']}; milliseconds of processor on one core, "
        f"median of {REPEATS}, from mesh in memory to K, M and stress recovery.",
        "",
        *boxes(),
        "",
        *others(),
        "",
        *sectionproperties(options.peer),
    ]
    if options.write:
        write(options.write, lines)
    else:
        print("\n".join(lines))


if __name__ == "__main__":
    main()
