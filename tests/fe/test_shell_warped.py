"""Cells that lock on very thin warped shells are told of; what is right is not."""

import re
from typing import Any

import numpy as np
import pytest
from samples.body_specs import shell_body, shell_parts
from samples.shell_cantilevers import box
from samples.shell_obstacle_course import (
    hemisphere,
    pinched_cylinder,
    scordelis,
    shell,
    twisted_beam,
)

from plymotion.preprocess.body import build_body
from plymotion.preprocess.fenicsx import NamedNodes, PlainMesh
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.shell_mesh import mesh_of

pytestmark = pytest.mark.one_end
QUADS = {"element": "quadrilateral"}
THIN_UZ = 5256.0  # of the thin twisted beam of MacNeal and Harder for a unit load along z


def twisted(n: tuple[int, int], h: float, cells: dict[str, Any] | None = None) -> dict[str, Any]:
    """The twisted beam under a unit load along z, with modes."""
    model = shell("twisted-beam", {"n_length": n[0], "n_width": n[1]}, 29e6, 0.22, h)
    model.supports = {"root": {"at": "root", "fixed": "all"}}
    model.loads = {"z": {"tip": {"at": "tip", "force": [0.0, 0.0, 1.0]}}}
    model.frequencies = {"count": 2}
    return {**model.spec(cells=cells), "probes": {"tip": {"at": "tip", "what": "uz"}}}


# Hyperbolic paraboloid z = x^2 - y^2 of length 1, clamped at x = -1/2, under its weight (Chapelle
# and Bathe): deflection of the free corner of its plane of symmetry, by thickness.
HYPAR = {0.01: 9.3355e-5, 0.001: 6.3941e-3, 0.0001: 0.52988}


def hypar(n: int, h: float) -> Any:
    """Displacement over reference and warnings of n x n/2 quadrilaterals on half of the hypar."""
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n // 2 + 1), indexing="ij")
    x, y = i.ravel() / n - 0.5, j.ravel() / n
    row = np.arange(x.size).reshape(i.shape)
    corners = [row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]]
    curves = {"clamp": row[0], "middle": row[:, 0]}
    curves = {name: np.stack([nodes[:-1], nodes[1:]], axis=1) for name, nodes in curves.items()}
    cells = np.stack([corner.ravel() for corner in corners], axis=1)
    tags = np.arange(1, x.size + 1)
    named = NamedNodes(tags, curves, {"tip": np.array([row[-1, 0]])})
    points = np.stack([x, y, x**2 - y**2], axis=1)
    region = np.zeros(len(cells), dtype=int)
    mesh = mesh_of(PlainMesh(points, cells, "mixed", 1, region, ("shell",), {}, named))
    spec = {
        "mesh": {"file": "hypar.msh"},
        "materials": {"steel": {"kind": "isotropic", "E": 2e11, "nu": 0.3, "rho": 8000.0}},
        "regions": {"all": {"material": "steel", "thickness": h}},
        "supports": {
            "clamp": {"at": "clamp", "fixed": "all"},
            "middle": {"at": "middle", "fixed": "symmetry-y"},
        },
        "loads": {"weight": {"all": {"force_per_area": [0.0, 0.0, -8000.0 * h]}}},
        "probes": {"tip": {"at": "tip", "what": "uz"}},
    }
    found = analyse(spec, mesh=mesh)
    return -found.probes.values[0, 0] / HYPAR[h], found.warnings


def told(warnings: Any, kind: str = "triangles") -> list[str]:
    """What the messages of this code begin with."""
    return [w["message"].split(":")[0] for w in warnings if w["code"] == f"shell-{kind}-warped"]


@pytest.mark.provokes("shell-quadrilaterals-warped")
@pytest.mark.parametrize(("h", "n", "bound"), [(0.001, 8, 0.5), (0.0001, 24, 0.65)])
def test_quadrilaterals_that_lock_and_the_cells_that_they_need(
    h: float, n: int, bound: float
) -> None:
    ratio, warnings = hypar(n, h)
    assert ratio < bound
    (message,) = [w["message"] for w in warnings if w["code"] == "shell-quadrilaterals-warped"]
    share, times = (
        float(number)
        for number in re.findall(r"take (\d+) %.*about ([\d.]+) times smaller", message)[0]
    )
    assert 0.01 * share == pytest.approx(1.0 - ratio, rel=0.4)
    # the advised mesh is right and silent, and not far finer than needed
    ratio, warnings = hypar(2 * round(0.5 * n * times), h)
    assert abs(ratio - 1.0) < 0.03
    assert warnings == ()
    ratio, warnings = hypar(2 * round(0.3 * n * times), h)
    assert ratio < 0.9
    assert told(warnings, "quadrilaterals") == ["load case weight"]


@pytest.mark.parametrize(("h", "n"), [(0.01, 8), (0.01, 16), (0.001, 16), (0.001, 32)])
def test_quadrilaterals_on_a_hypar_that_are_right(h: float, n: int) -> None:
    ratio, warnings = hypar(n, h)
    assert abs(ratio - 1.0) < 0.035
    assert told(warnings, "quadrilaterals") == []


@pytest.mark.parametrize(
    ("problem", "expected"),
    [
        (hemisphere(4), ["load case pull"]),  # 0.28 of the displacement
        (hemisphere(16), []),
        (scordelis(4), []),
        (pinched_cylinder(8), []),
        (twisted_beam((6, 1), "z"), []),
        (box((40, 4, 2), "cas15"), []),
    ],
    ids=["hemisphere 4", "hemisphere 16", "Scordelis-Lo 4", "cylinder 8", "twisted beam", "box"],
)
def test_other_shells_of_quadrilaterals(problem: Any, expected: list[str]) -> None:
    assert told(analyse(problem[0].spec(cells=QUADS)).warnings, "quadrilaterals") == expected


@pytest.mark.provokes("shell-triangles-warped")
@pytest.mark.parametrize("n", [(12, 2), (24, 4), (48, 8)])
def test_triangles_that_lock(n: tuple[int, int]) -> None:
    found = analyse(twisted(n, 0.0032))
    assert found.probes.values[0, 0] / THIN_UZ < 0.75
    codes = {w["code"] for w in found.warnings}
    assert codes - {"few-digits"} == {"shell-triangles-warped"}
    case, modes = told(found.warnings)
    assert case == "load case z"
    assert modes in ("mode 1 and 1 more", "mode 2 and 1 more")


@pytest.mark.parametrize(
    ("n", "cells", "bounds"), [((12, 2), QUADS, (0.99, 1.01)), ((96, 16), {}, (0.96, 1.0))]
)
def test_advice_helps(n: tuple[int, int], cells: dict[str, Any], bounds: Any) -> None:
    found = analyse(twisted(n, 0.0032, cells))
    assert bounds[0] < found.probes.values[0, 0] / THIN_UZ < bounds[1]
    assert told(found.warnings) == []


def test_limit_is_between_what_is_wrong_and_what_is_right() -> None:
    """Half as many cells are 17 % wrong at this thickness, these 2 %."""
    right = analyse(twisted((24, 4), 0.05))
    fine = analyse(twisted((48, 8), 0.05, QUADS)).probes.values[0, 0]
    assert right.probes.values[0, 0] / fine == pytest.approx(1.0, abs=0.05)
    assert told(right.warnings) == []
    wrong = analyse(twisted((12, 2), 0.05))
    assert wrong.probes.values[0, 0] / fine < 0.85
    assert len(told(wrong.warnings)) == 2


@pytest.mark.parametrize(
    ("problem", "expected"),
    [
        (hemisphere(8), ["load case pull"]),  # 0.40 of the displacement
        (hemisphere(16), ["load case pull"]),  # 0.90
        (hemisphere(32), []),
        (scordelis(4), []),  # 1.04
        (box((40, 4, 2), "cas15"), []),
    ],
    ids=["hemisphere 8", "hemisphere 16", "hemisphere 32", "Scordelis-Lo 4", "box"],
)
def test_other_shells(problem: Any, expected: list[str]) -> None:
    assert told(analyse(problem[0].spec()).warnings) == expected


@pytest.mark.parametrize(("h", "n"), [(0.0032, (12, 2)), (0.32, (12, 2))])
def test_bodies(h: float, n: tuple[int, int]) -> None:
    """All modes of a thin body with these cells are wrong, those of a thick one right."""
    package = build_body(
        shell_body(
            body="strip",
            shell=shell_parts(twisted(n, h)),
            modes=[{"kind": "lowest", "count": 2}],
            interfaces={"root": {"at": "root"}, "tip": {"at": "tip", "link": "average"}},
        )
    )
    labels = told(package.provenance["warnings"])
    assert [label[:5] for label in labels] == (["mode "] if h < 0.1 else [])
