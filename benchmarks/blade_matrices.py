"""6x6 matrices of a windIO blade beside those that its file has: a table of all stations.

    plymotion blade FILE.yaml --at <grid of the file> -o DIR --no-estimate
    PYTHONPATH=.:benchmarks python benchmarks/blade_matrices.py FILE.yaml DIR [every]

Ours over theirs: mass, EA, EI about the tension centre (flap and edge), GJ of the free section
(1 / S44); differences of the centres of mass and tension in per cent of the chord, to the leading
edge and to the suction side. Last: mass, and the two lowest frequencies of the clamped blade at
rest, with our matrices and theirs in the same beam; these need FEniCSx. `--grid FILE.yaml` prints
the stations of the file for --at.
"""

import csv
import io
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml

import plymotion as pm
from plymotion.solver.package.body.package_file import read_package
from plymotion.solver.report.section.codes import BLADE_AXES_LEADING_EDGE, convert, transform

UPPER = [(i, j) for i in range(6) for j in range(i, 6)]


def matrix(values: dict[str, float], letter: str) -> np.ndarray:
    found = np.zeros((6, 6))
    for i, j in UPPER:
        found[i, j] = found[j, i] = float(values[f"{letter}{i + 1}{j + 1}"])
    return found


def theirs(blade: dict) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Grid, stiffness and mass of the file in our axes, about the reference axis."""
    properties = blade["structure"]["elastic_properties"]
    stiffness, inertia = properties["stiffness_matrix"], properties["inertia_matrix"]
    grid = np.array(stiffness["grid"])
    found: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    for k in range(len(grid)):
        K = matrix({f"K{key[1:]}": stiffness[key][k] for key in stiffness if key != "grid"}, "K")
        m, x, y, edge, flap, cross = (
            inertia[key][k] for key in ("mass", "cm_x", "cm_y", "i_edge", "i_flap", "i_cp")
        )
        M = np.diag([m, m, m, edge, flap, edge + flap])
        M[0, 5], M[1, 5], M[2, 3], M[2, 4], M[3, 4] = -m * y, m * x, m * y, -m * x, -cross
        M += np.triu(M, 1).T
        for into, A, kind in zip(found, (K, M), ("stiffness", "mass"), strict=True):
            into.append(
                convert(A, "plymotion", kind, source="beamdyn", blade_axes=BLADE_AXES_LEADING_EDGE)
            )
    return grid, *found


def tension_centre(K: np.ndarray) -> np.ndarray:
    S = np.linalg.inv(K)
    M2, M3 = np.linalg.solve(S[4:, 4:], -S[4:, 0])
    return np.array([-M3, M2])


def mass_centre(M: np.ndarray) -> np.ndarray:
    return np.array([-M[0, 5], M[0, 4]]) / M[0, 0]


def numbers(K: np.ndarray, M: np.ndarray) -> np.ndarray:
    """Mass, EA, EI flap, EI edge, GJ."""
    S = np.linalg.inv(transform(K, tension_centre(K)))
    EI = np.linalg.inv(S[4:, 4:])
    return np.array([M[0, 0], 1.0 / S[0, 0], EI[0, 0], EI[1, 1], 1.0 / S[3, 3]])


def beam_of(table: str, K: list[np.ndarray], M: list[np.ndarray]) -> str:
    """The table of a beam with other matrices."""
    lines = table.splitlines(keepends=True)
    remarks = [line for line in lines if line.startswith("#")]
    rows = list(csv.DictReader(lines[len(remarks) :]))
    stream = io.StringIO(newline="")
    writer = csv.DictWriter(stream, rows[0])
    writer.writeheader()
    for row, stiffness, mass in zip(rows, K, M, strict=True):
        own = {"K": stiffness, "M": mass}
        entries = {f"{c}{i + 1}{j + 1}": float(A[i, j]) for c, A in own.items() for i, j in UPPER}
        writer.writerow(row | entries)
    return "".join(remarks) + stream.getvalue()


def frequencies(table: str) -> list[float]:
    """The two lowest frequencies [Hz] of a clamped beam at rest."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "beam.csv"
        file.write_text(table, encoding="utf-8")
        case = pm.Case("blade", solver={"t_end": 1e-3, "output_step": 1e-3})
        case.ground["hub"] = {"position": (0, 0, 0)}
        case.bodies["blade"] = {
            "kind": "beam",
            "table": str(file),
            "modes": [{"kind": "lowest", "count": 4}],
            "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
        }
        case.joints["clamp"] = {"kind": "fixed", "between": ["ground.hub", "blade.root"]}
        pm.run(case, out=folder)
        (package,) = Path(folder, "bodies").glob("*.vtkhdf")
        return [w / (2.0 * np.pi) for w in read_package(package).frequencies[:2]]


def main(file: Path, folder: Path | None, every: int) -> None:
    with file.open(encoding="utf-8") as stream:
        blade = yaml.load(stream, Loader=yaml.CSafeLoader)["components"]["blade"]
    grid, K_theirs, M_theirs = theirs(blade)
    if folder is None:
        print(",".join(map(repr, grid.tolist())))
        return
    with (folder / "blade.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    ours = {round(float(row["r"]), 6): row for row in rows}
    print("| r | mass | EA | EI flap | EI edge | GJ | mass centre | tension centre | removed |")
    print("|---|---|---|---|---|---|---|---|---|")
    for k, r in enumerate(grid):
        row = ours[round(float(r), 6)]
        K, M = matrix(row, "K"), matrix(row, "M")
        ratio = numbers(K, M) / numbers(K_theirs[k], M_theirs[k])
        chord = float(row["chord_m"])
        shifts = [mass_centre(M) - mass_centre(M_theirs[k])]
        shifts += [tension_centre(K) - tension_centre(K_theirs[k])]
        moved = " | ".join(", ".join(f"{100 * x / chord:.1f}" for x in s) for s in shifts)
        if k % every == 0 or k == len(grid) - 1:
            cells = " | ".join(f"{x:.3f}" for x in ratio)
            print(f"| {r:.3f} | {cells} | {moved} | {100 * float(row['removed']):.1f} % |")
    axis = blade["reference_axis"]
    line = np.array([np.interp(grid, axis[c]["grid"], axis[c]["values"]) for c in "xyz"]).T
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    masses = [
        np.trapezoid([float(ours[round(float(r), 6)]["mass_kg_m"]) for r in grid], s),
        np.trapezoid([M[0, 0] for M in M_theirs], s),
    ]
    print(f"blade: {masses[0]:.0f} kg, theirs {masses[1]:.0f} kg, {masses[0] / masses[1] - 1:+.2%}")
    beam = (folder / "beam.csv").read_text(encoding="utf-8")
    for whose, text in (("ours", beam), ("theirs", beam_of(beam, K_theirs, M_theirs))):
        print(f"{whose}: " + ", ".join(f"{f:.4f} Hz" for f in frequencies(text)))


if __name__ == "__main__":
    if sys.argv[1] == "--grid":
        main(Path(sys.argv[2]), None, 1)
    else:
        main(Path(sys.argv[1]), Path(sys.argv[2]), int((*sys.argv, "1")[3]))
