"""Sections of VABS and BECAS: the same numbers as an independent code on the same mesh."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.vabs_peer import orthotropic, relative, stiffness, turned

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.inputs.section.vabs import is_of_another_code, spec_of_another_code
from plymotion.solver.report.section.codes import write_vabs

ORDER = ("E1", "E2", "E3", "G12", "G13", "G23", "nu12", "nu13", "nu23")
CARBON = dict(zip(ORDER, (142e9, 9.8e9, 9.1e9, 6.0e9, 5.5e9, 4.8e9, 0.3, 0.32, 0.42), strict=True))
FOAM = dict(zip(ORDER, (2e8, 1e8, 1.5e8, 5e7, 4e7, 6e7, 0.2, 0.25, 0.3), strict=True))


def mesh_of(shear: float = 0.0, bulge: float = 0.0) -> tuple[Any, list[dict[str, Any]]]:
    """Four by three cells: Q9, Q8, Q4, quadrilaterals of 6 and 7 nodes, T6 and T3 side by side.

    `shear` makes trapezoids of rectangles, `bulge` curves the edges of quadrilaterals.
    """
    s, t = np.meshgrid(np.linspace(0, 4, 9), np.linspace(0, 3, 7), indexing="ij")
    x = 0.02 * (s - 1.7) + shear * 0.004 * s * t + bulge * 0.002 * np.sin(np.pi * t / 3)
    y = 0.011 * (t - 1.1) + bulge * 0.003 * np.sin(np.pi * s / 4)
    points = np.stack([x, y], axis=-1).reshape(-1, 2)
    number = np.arange(63).reshape(9, 7)
    dropped = {(0, 1): [8], (1, 1): [5, 7, 8], (2, 1): [4, 5, 6, 7, 8], (3, 1): [6, 8]}
    cells = []
    for i in range(4):
        for j in range(3):
            a, b = 2 * i, 2 * j
            nine = [
                number[p]
                for p in (
                    (a, b),
                    (a + 2, b),
                    (a + 2, b + 2),
                    (a, b + 2),
                    (a + 1, b),
                    (a + 2, b + 1),
                    (a + 1, b + 2),
                    (a, b + 1),
                    (a + 1, b + 1),
                )
            ]
            if j == 2 and i < 2:  # two triangles, of 6 or of 3 nodes
                for local in ((0, 1, 2, 4, 5, 8), (0, 2, 3, 8, 6, 7)):
                    kept = local if i == 0 else local[:3]
                    present = list(range(len(kept)))
                    cells.append(
                        {"triangle": True, "present": present, "nodes": [nine[k] for k in kept]}
                    )
                continue
            present = [k for k in range(9) if k not in dropped.get((i, j), [])]
            cells.append(
                {"triangle": False, "present": present, "nodes": [nine[k] for k in present]}
            )
    generator = np.random.default_rng(5)
    for cell in cells:
        cell["material"] = int(generator.integers(2))
        cell["theta1"] = float(generator.uniform(-180, 180))
        cell["theta3"] = float(generator.choice([0.0, 30.0, -45.0, 90.0]))
        cell["C"] = orthotropic((CARBON, FOAM)[cell["material"]])
    return points, cells


def nine_numbers(cell: dict[str, Any]) -> list[int]:
    """The row of a VABS file: nodes from 1, zeros for absent ones."""
    row = [0] * 9
    for local, node in zip(cell["present"], cell["nodes"], strict=True):
        place = local + 1 if cell["triangle"] and local > 2 else local
        row[place] = int(node) + 1
    return row


def vabs_text(points: Any, cells: list[dict[str, Any]], *, new: bool, k: Any = None) -> str:
    used = sorted({node for cell in cells for node in cell["nodes"]})
    lines = [f"{int(new)} {len(cells)}", "1 0 0", f"{int(k is not None)} 0 0 0"]
    if k is not None:
        lines.append(" ".join(map(str, k)))
    lines.append(f"{len(points)} {len(cells)} 2")
    lines += [f"{i} {x!r} {y!r}" for i, (x, y) in enumerate(points.tolist(), start=1)]
    order = np.random.default_rng(1).permutation(len(cells))  # any order of rows
    lines += [f"{i + 1} {' '.join(map(str, nine_numbers(cells[i])))}" for i in order]
    if new:
        lines += [f"{i + 1} {i + 1} {cells[i]['theta1']!r}" for i in order]
        lines += [f"{i + 1} {c['material'] + 1} {c['theta3']!r}" for i, c in enumerate(cells)]
    else:
        for i in order:
            cell, angles = cells[i], [0.0] * 9
            if np.ndim(cell["theta1"]) == 0:
                angles[:2] = [cell["theta1"], 540.0]
            else:
                for local, angle in zip(cell["present"], cell["theta1"], strict=True):
                    angles[local + 1 if cell["triangle"] and local > 2 else local] = float(angle)
            text = " ".join(map(repr, angles))
            lines.append(f"{i + 1} {cell['material'] + 1} {cell['theta3']!r} {text}")
    for i, constants in enumerate((CARBON, FOAM), start=1):
        values = [constants[key] for key in ORDER]
        lines += [f"{i} 1", *(" ".join(map(repr, values[j : j + 3])) for j in (0, 3, 6)), "1600."]
    assert used
    return "\n".join(lines) + "\n"


def solved(file: Path, folder: Path) -> Any:
    return analyse(spec_of_another_code(file, folder), estimate=False)


def clockwise(row: list[int]) -> list[int]:
    """The nodes of a row of a VABS file in the other sense of rotation."""
    order = (0, 2, 1, 3, 6, 5, 4, 7, 8) if row[3] == 0 else (0, 3, 2, 1, 7, 6, 5, 4, 8)
    return [row[k] for k in order]


@pytest.mark.one_end
def test_cells_numbered_clockwise(tmp_path: Path) -> None:
    """The sense of rotation of the nodes of a cell has no meaning; every second cell is turned."""
    points, cells = mesh_of(0.3)
    text = vabs_text(points, cells, new=True)
    turned_over = text
    for cell in cells[::2]:
        row = nine_numbers(cell)
        old, new = (" ".join(map(str, nodes)) for nodes in (row, clockwise(row)))
        assert f" {old}\n" in turned_over
        turned_over = turned_over.replace(f" {old}\n", f" {new}\n")
    found = []
    for name, content in (("one", text), ("two", turned_over)):
        file = tmp_path / f"{name}.sg"
        file.write_text(content)
        found.append(solved(file, tmp_path).K)
    assert relative(*found) < 1e-12


@pytest.mark.parametrize("new", [True, False])
@pytest.mark.parametrize(("shear", "bulge"), [(0.0, 0.0), (0.3, 0.0), (0.0, 1.0)])
def test_vabs_mesh(new: bool, shear: float, bulge: float, tmp_path: Path) -> None:
    """All kinds of cells in one mesh, an orientation for each, rows in any order."""
    points, cells = mesh_of(shear, bulge)
    if bulge:  # curved triangles depend on the rule of integration
        cells = [cell for cell in cells if not cell["triangle"]]
    file = tmp_path / "mixed.dat"
    file.write_text(vabs_text(points, cells, new=new))
    assert is_of_another_code(file)
    found = solved(file, tmp_path)
    expected = stiffness(*compact(points, cells))
    assert relative(found.K, expected) < 1e-8
    assert set(found.mesh.cell_types) == ({9, 23, 28} if bulge else {5, 9, 22, 23, 28})


def compact(points: Any, cells: list[dict[str, Any]]) -> tuple[Any, list[dict[str, Any]]]:
    """Only the nodes in use, for the dense matrices."""
    used = sorted({int(n) for cell in cells for n in cell["nodes"]})
    row = {node: i for i, node in enumerate(used)}
    return points[used], [{**c, "nodes": [row[int(n)] for n in c["nodes"]]} for c in cells]


@pytest.mark.one_end
def test_orientation_that_turns_inside_cells(tmp_path: Path) -> None:
    """Nine values of theta1: interpolated with the functions of the cell."""
    points, cells = mesh_of(0.2)
    generator = np.random.default_rng(3)
    for cell in cells:
        if not cell["triangle"]:
            cell["theta1"] = 30.0 + generator.uniform(-20, 20, len(cell["nodes"]))
    file = tmp_path / "curved.sg"
    file.write_text(vabs_text(points, cells, new=False))
    assert relative(solved(file, tmp_path).K, stiffness(*compact(points, cells))) < 1e-8


@pytest.mark.one_end
def test_curvature_of_a_vabs_file(tmp_path: Path) -> None:
    points, cells = mesh_of()
    file = tmp_path / "twisted.sg"
    file.write_text(vabs_text(points, cells, new=True, k=(0.5, 0.1, -0.2)))
    found = solved(file, tmp_path)
    np.testing.assert_allclose(found.initial_curvature, [0.5, 0.1, -0.2])
    assert relative(found.K, stiffness(*compact(points, cells))) > 1e-4


def kind_2(C: Any, rho: float) -> list[str]:
    """Stiffness in our order as the 21 constants of VABS: 11 12 13 22 23 33, upper triangle."""
    order = [0, 5, 4, 1, 3, 2]
    theirs = C[np.ix_(order, order)]
    rows = [" ".join(repr(float(v)) for v in theirs[i, i:]) for i in range(6)]
    return [*rows, repr(rho)]


@pytest.mark.one_end
def test_anisotropic_materials(tmp_path: Path) -> None:
    """A turned orthotropic material by 21 constants, and as a layer with theta1 and theta3."""
    points, cells = mesh_of(0.2)
    for cell in cells:
        cell["theta1"], cell["theta3"] = 20.0, 35.0
    same = vabs_text(points, cells, new=True)
    expected = stiffness(*compact(points, cells))
    for cell in cells:
        cell["theta1"] = cell["theta3"] = 0.0
    text = vabs_text(points, cells, new=True)
    head = text[: text.index("\n1 1\n" + " ".join(repr(CARBON[key]) for key in ORDER[:3]))]
    blocks = []
    for i, constants in enumerate((CARBON, FOAM), start=1):
        blocks += [f"{i} 2", *kind_2(turned(orthotropic(constants), 20.0, 35.0), 1600.0)]
    by_constants, by_angles = tmp_path / "constants.sg", tmp_path / "angles.sg"
    by_constants.write_text(head + "\n" + "\n".join(blocks) + "\n")
    by_angles.write_text(same)
    found = solved(by_constants, tmp_path)
    assert relative(found.K, solved(by_angles, tmp_path).K) < 1e-10
    assert relative(found.K, expected) < 1e-8
    assert pytest.approx(solved(by_angles, tmp_path).M, rel=1e-12) == found.M
    again = solved(write_vabs(found, tmp_path / "written.sg"), tmp_path)
    for before, after in zip(found.recovery.materials, again.recovery.materials, strict=True):
        first, second = found.recovery.materials[before], again.recovery.materials[after]
        assert second["C"] == pytest.approx(first["C"], rel=1e-12)


@pytest.mark.one_end
@pytest.mark.provokes("model-not-computed")
def test_flags_and_constants_that_are_not_used(tmp_path: Path) -> None:
    """Damping and expansions are read past, and the result says what it does not contain."""
    points, cells = mesh_of()
    plain, more = tmp_path / "plain.sg", tmp_path / "more.sg"
    text = vabs_text(points, cells, new=True)
    plain.write_text(text)
    lines = text.splitlines()
    lines[1], lines[2] = "1 1 3", "0 0 1 1"
    first = len(lines) - 10 - len(cells)
    lines[first : first + len(cells)] = [f"{x} 0.01" for x in lines[first : first + len(cells)]]
    for end in (len(lines), len(lines) - 5):
        lines[end:end] = ["0.02", "1e-6 2e-6 3e-6"]
    more.write_text("\n".join(lines) + "\n")
    found = solved(more, tmp_path)
    assert relative(found.K, solved(plain, tmp_path).K) < 1e-14
    message = next(w["message"] for w in found.warnings if w["code"] == "model-not-computed")
    assert "trapeze, vlasov, damping, thermal" in message


def becas_folder(folder: Path, points: Any, cells: list[dict[str, Any]]) -> Path:
    folder.mkdir()
    number = 10 * np.arange(1, len(points) + 1)
    rows = []
    for i, cell in enumerate(cells, start=1):
        nodes = [int(number[n]) for n in cell["nodes"]]
        if cell["triangle"]:
            nodes = [*nodes[:3], 0, *nodes[3:], 0]
        rows.append([i, *nodes, *[0] * (8 - len(nodes))])
    np.savetxt(folder / "N2D.in", np.column_stack([number, points]), fmt="%d %.17g %.17g")
    np.savetxt(folder / "E2D.in", rows, fmt="%d")
    np.savetxt(
        folder / "EMAT.in",
        [[i, c["material"] + 1, c["theta3"], c["theta1"]] for i, c in enumerate(cells, start=1)],
        fmt="%d %d %.17g %.17g",
    )
    np.savetxt(folder / "MATPROPS.in", [[*(m[key] for key in ORDER), 1.0] for m in (CARBON, FOAM)])
    return folder


def test_becas_mesh(tmp_path: Path) -> None:
    """Quadrilaterals of 4 and 8 nodes, and triangles."""
    points, cells = mesh_of(0.3)
    some = [c for c in cells if c["triangle"] or len(c["present"]) in (4, 8)]
    some += [
        {**c, "present": c["present"][:8], "nodes": c["nodes"][:8]}
        for c in cells
        if len(c["present"]) == 9
    ]
    folder = becas_folder(tmp_path / "blade", *compact(points, some))
    assert is_of_another_code(folder)
    expected = stiffness(*compact(points, some))
    assert relative(solved(folder, tmp_path).K, expected) < 1e-8


@pytest.mark.one_end
def test_estimate_of_given_cells(tmp_path: Path) -> None:
    """The estimate is of the solution with the functions of the cells; refinement reduces it."""
    points, cells = mesh_of()
    for cell in cells:
        cell["theta1"] = 0.0
    file = tmp_path / "mixed.dat"
    file.write_text(vabs_text(points, cells, new=True))
    spec = spec_of_another_code(file, tmp_path)
    first = analyse(spec)
    finer = analyse(spec, accuracy=2e-3)
    error = relative(first.K, finer.K)
    size = np.sqrt(np.outer(np.diag(finer.K), np.diag(finer.K)))
    assert 0.4 * error < (first.error_estimate / size).max()
    assert finer.provenance["refinements"][-1]["error"] < 2e-3
