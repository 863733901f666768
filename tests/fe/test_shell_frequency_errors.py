"""Frequencies have estimates of their errors by the mesh where that is cheap."""

from typing import Any

import numpy as np
import pytest
from samples.shell_specs import plate

from plymotion.preprocess.shell.analyses import discretisation
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.solver.report.shell.findings import shell_json
from plymotion.solver.report.shell.shell_text import shell_text

pytestmark = pytest.mark.one_end
CLAMPED = {"left": {"at": "left", "fixed": "all"}}
LIMIT = "unknowns the estimate takes several times as long"


def modes_of(n: int, free: bool = False, **asked: Any) -> Any:
    """A square cantilever, or a free square, of n x n quadrilaterals."""
    frequencies = {"count": 6, "free": free, **asked}
    spec = plate(n, 0.01, supports={} if free else CLAMPED, frequencies=frequencies)
    spec["mesh"]["element"] = "quadrilateral"
    return analyse(spec)


def coarse(found: Any) -> list[str]:
    return [w["message"] for w in found.warnings if w["code"] == "shell-mesh-coarse"]


@pytest.mark.provokes("shell-mesh-coarse")
@pytest.mark.parametrize("free", [False, True])
def test_errors_come_without_being_asked_for(free: bool) -> None:
    right = modes_of(40, free).modes
    for n in (4, 8, 16):
        found = modes_of(n, free)
        modes = found.modes
        assert modes.n_zero == right.n_zero == (6 if free else 0)
        assert not modes.error[: modes.n_zero].any()
        elastic = slice(modes.n_zero, None)
        true = modes.frequencies[elastic] / right.frequencies[elastic] - 1.0
        assert np.abs(modes.error[elastic] - true).max() < 0.4 * np.abs(true).max() + 0.002
        # any of the frequencies, not only the first, and only where one is wrong
        told = coarse(found)
        assert len(told) == (np.abs(modes.error) > 0.05).any()
        assert len(told) == (n == 4 or (free and n == 8))
        assert len(told) == ("shell-mesh-coarse" in {w["code"] for w in found.warnings})
        assert all(message.startswith("frequency 6, ") for message in told)
        assert shell_json(found)["frequency_errors"] == modes.error[elastic].tolist()
        assert "Mesh error" in shell_text(found)


def test_a_long_estimate_is_left_out_with_the_key_that_asks_for_it() -> None:
    """25 x 25 cells have 4056 unknowns."""
    for n, left_out in ((24, False), (25, True)):
        found = modes_of(n)
        assert (6 * (n + 1) ** 2 > discretisation.CHEAP) == left_out
        table = shell_json(found)
        assert (table["frequency_errors"] is None) == left_out
        assert (table["frequency_errors_left_out"] is not None) == left_out
        assert (LIMIT in shell_text(found)) == left_out
        assert ("error = true in [frequencies]" in shell_text(found)) == left_out
    asked = shell_json(modes_of(25, error=True))
    assert asked["frequency_errors"] is not None
    assert asked["frequency_errors_left_out"] is None
    refused = modes_of(4, error=False)
    assert refused.modes.error is None
    assert "not estimated: error = false" in shell_text(refused)
    assert coarse(refused) == []
