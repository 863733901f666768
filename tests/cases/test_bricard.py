"""Bricard's mechanism, with its redundant equation and without."""

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case

REFERENCE = "a04_bricard"


@pytest.mark.parametrize("name", ["hinges", "independent"])
def test_motion_for_ten_seconds(name, repository, tmp_path, reference):
    runs = case_runs(repository, "bricard", tmp_path)
    t, s, summary = run_case(runs / f"{name}.json")
    assert summary["completed"]
    for point in reference["positions"]:
        k = int(np.searchsorted(t, point["t"] - 1e-9))
        error = np.linalg.norm([s[c][k] - x for c, x in zip("xyz", point["x"], strict=True)])
        assert error < reference["tolerance"], point
    assert summary["checks"]["degrees_of_freedom"] == 1
    assert summary["checks"]["energy_drift_relative"] < 1e-6
