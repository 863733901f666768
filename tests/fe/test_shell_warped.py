"""Triangles that lock on very thin warped shells are told of; what is right is not."""

from typing import Any

import pytest
from body_specs import shell_body, shell_parts
from shell_cantilevers import box
from shell_obstacle_course import hemisphere, scordelis, shell

from plymotion.preprocess.body import build_body
from plymotion.preprocess.shell.analysis import analyse

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


def told(warnings: Any) -> list[str]:
    """What the messages of this code begin with."""
    return [w["message"].split(":")[0] for w in warnings if w["code"] == "shell-triangles-warped"]


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
