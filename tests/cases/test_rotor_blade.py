"""The blade of cases/rotor-blade: its table, its frequencies at rest and in a spin, its motion."""

import json

import numpy as np
import pytest
from samples.beam_tables import rod_frequencies
from samples.blade_samples import rows_of
from samples.case_samples import case_runs, run_case

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.tables.beam_keys import BeamBody
from plymotion.solver.inputs.case.tables.laws import FOLDER
from plymotion.solver.package import read_package

# Hz at 0, 5 and 10 rad/s of ten segments with floating frames, 80 elements, without second-order
# terms: a second route to the stiffening of the spin (test_segments.py has its proofs).
# source = "self"
SEGMENTS = {
    0.0: (3.1137, 4.66681, 8.19174, 13.7683),
    5.0: (3.3131, 4.70366, 8.40424, 13.8634),
    10.0: (3.82992, 4.80866, 9.01033, 14.1274),
}


@pytest.fixture(scope="module")
def case(repository):
    return repository / "cases/rotor-blade"


def test_the_shipped_table_is_that_of_the_description(fenicsx, case, tmp_path):
    words = ["blade", str(case / "blade.yaml"), "--at", "0.5,1", "-o", str(tmp_path), "--quiet"]
    assert main([*words, "--no-estimate"]) == 0
    shipped, found = (rows_of(folder / "beam.csv") for folder in (case, tmp_path))
    for row, known in zip(found, (shipped[10], shipped[20]), strict=True):
        for key in ("x_m", "y_m", "twist_deg", "K11", "K44", "K55", "K66", "M11", "M44", "A1"):
            assert float(row[key]) == pytest.approx(float(known[key]), rel=1e-6), key


def test_first_flap_and_edge_frequencies_are_those_of_the_rod(case, repository):
    """At rest: integrated along the curved line, without elements (samples/beam_tables.py)."""
    package = read_package(repository / "tests/packages/rotor-blade/blade.stiffened.vtkhdf")
    body = {
        "kind": "beam",
        "table": "beam.csv",
        "modes": [{"kind": "lowest", "count": 2}],
        "interfaces": {"root": {"at": "start"}},
    }
    read = BeamBody.model_validate(body, context={FOLDER: case})
    w, mass = rod_frequencies(read, package.frequencies[:2])
    np.testing.assert_allclose(package.frequencies[:2], w, rtol=1.5e-3)
    assert package.mode_labels[:2] == ("bending-xz 1", "bending-xy 1")
    assert package.invariants.mass == pytest.approx(mass, rel=1e-3)


def test_frequencies_over_speed_are_those_of_segments(case, repository, tmp_path, capsys):
    packages = str(repository / "tests/packages/rotor-blade")
    words = ["modes", str(case / "case.toml"), "--at", "spin=0:10:5", "--count", "4", "--json"]
    assert main([*words, "--packages", packages, "--out", str(tmp_path)]) == 0
    found = json.loads(capsys.readouterr().out)
    for k, speed in enumerate(found["speeds"]):
        w = [branch["angular_frequency"][k] for branch in found["branches"]]
        np.testing.assert_allclose(np.array(w) / (2.0 * np.pi), SEGMENTS[speed], rtol=3e-3)
    flap = found["branches"][0]["angular_frequency"]
    assert flap[-1] > 1.2 * flap[0]


def test_the_spin_holds_the_blade_against_a_push(repository, tmp_path_factory):
    folder = case_runs(repository, "rotor-blade", tmp_path_factory.mktemp("build"))
    highest = {}
    for name in ("linear", "stiffened"):
        t, signals, summary = run_case(folder / f"{name}.json")
        assert summary["completed"]
        highest[name] = signals["flap"][t > 4.0].max()
        assert ("stiffening-matters" in {w["code"] for w in summary["warnings"]}) == (
            name == "linear"
        )
    assert summary["warnings"] == []
    assert 0.05 < highest["stiffened"] < 0.95 * highest["linear"]
