"""Beams from a CSV table of stations: what the keys become, messages, segments, the package."""

from typing import Any

import numpy as np
import pytest
from samples.beam_tables import ANGLES, AT, MASS, POINTS, SHARE, STIFFNESS, columns, write_table

from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.sections import given_section
from plymotion.solver.inputs.case.bodies.specifications import BodySpecs
from plymotion.solver.inputs.case.checks import in_parts
from plymotion.solver.inputs.case.tables.laws import FOLDER
from plymotion.solver.inputs.case.tables.schema import Mechanism, resolved
from plymotion.solver.package.common.plain_data import SpecError

BODY = {
    "kind": "beam",
    "table": "beam.csv",
    "modes": [{"kind": "lowest", "count": 3}],
    "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
}


def mechanism(folder, **keys: Any) -> Mechanism:
    solver = {"t_end": 1.0, "output_step": 0.1}
    table = {"bodies": {"blade": {**BODY, **keys}}, "solver": solver}
    return Mechanism.model_validate(table, context={FOLDER: folder})


def test_a_table_becomes_line_twist_and_stations(tmp_path):
    write_table(tmp_path / "beam.csv")
    _, specs, problems = in_parts(mechanism(tmp_path), BodySpecs(tmp_path))
    assert not problems
    spec = specs["blade"].content
    assert specs["blade"].sources == (tmp_path / "beam.csv",)
    beam = read_spec(dict(spec))
    assert beam.elements == 2 * (len(AT) - 1)
    for point in POINTS:  # every station has a node
        assert np.linalg.norm(beam.nodes_B - point, axis=1).min() < 1e-9
    for station, share in zip(spec["stations"], SHARE, strict=True):
        np.testing.assert_allclose(station["section"]["stiffness"], share * STIFFNESS)
        np.testing.assert_allclose(station["section"]["mass"], share * MASS)
        assert station["section"]["trapeze"] == [0.01] * 6
    # x2 of the first element: the angle of its middle, a positive one turns y to z
    first = beam.A_BE[0][:, 1]
    middle = 0.5 * np.linalg.norm(beam.nodes_B[1] - beam.nodes_B[0]) / beam.length
    angle = np.radians(np.interp(middle, beam.stations, ANGLES))
    np.testing.assert_allclose(first[1:], [np.cos(angle), np.sin(angle)], atol=2e-3)


def test_a_run_file_needs_no_table(tmp_path):
    write_table(tmp_path / "beam.csv")
    one = mechanism(tmp_path)
    (tmp_path / "beam.csv").unlink()
    two = resolved(one.model_dump(), "run file")
    assert two.bodies["blade"] == one.bodies["blade"]


def test_segments_of_a_table_have_its_stations(tmp_path):
    write_table(tmp_path / "beam.csv")
    _, specs, problems = in_parts(mechanism(tmp_path, segments=3), BodySpecs(tmp_path))
    assert not problems
    assert len(specs) == 3
    whole = mechanism(tmp_path).bodies["blade"].stations
    for k in range(3):
        stations = specs[f"blade-{k + 1}"].content["stations"]
        assert [s["at"] for s in stations] == pytest.approx([3.0 * s.at - k for s in whole])
        assert [s["section"]["mass"] for s in stations] == [s.mass for s in whole]


@pytest.mark.parametrize(
    "section", [{"stiffness": np.eye(6).tolist()}, {"stiffness": 1, "mass": 2, "trapeze": 3}]
)
def test_the_preprocessor_refuses_other_matrices(section):
    with pytest.raises(SpecError, match=r"section.(stiffness|mass): expected .*numbers"):
        given_section(section)


@pytest.mark.parametrize(
    ("change", "keys", "message"),
    [
        (lambda t: t.pop("K44"), {}, "beam.csv: column 'K44' is missing; expected x_m"),
        (
            lambda t: t.update(twist=t["K44"]),
            {},
            "unknown column 'twist'; did you mean 'twist_deg'",
        ),
        (lambda t: t["K44"].__setitem__(1, "x"), {}, r"beam.csv line 4: .*expected numbers"),
        (lambda t: t["K44"].__setitem__(1, np.inf), {}, "line 4: expected 52 finite numbers"),
        (
            lambda t: t["K44"].__setitem__(1, -1.0),
            {},
            "stations.1.stiffness\\n.*expected a positive definite matrix",
        ),
        (
            lambda t: [t[k].__setitem__(1, t[k][0]) for k in ("x_m", "y_m", "z_m")],
            {},
            "two neighbouring stations have the same place",
        ),
        (lambda t: t.pop("A3"), {}, "column 'A3' is missing"),
        (lambda t: [t.update({k: v[:1]}) for k, v in t.items()], {}, "two stations or more"),
        (lambda t: None, {"length": 2.0}, "expected no `length`, which the file of `table` has"),
        (lambda t: None, {"table": "beem.csv"}, "beem.csv: cannot be read"),
        (lambda t: None, {"table": "."}, "cannot be read .expected a file"),
    ],
)
def test_messages_name_file_and_expectation(tmp_path, change, keys, message):
    table = columns()
    change(table)
    write_table(tmp_path / "beam.csv", table)
    with pytest.raises(ValueError, match=message):
        mechanism(tmp_path, **keys)


@pytest.mark.parametrize(
    ("station", "message"),
    [
        ({}, "expected either `section` or `stiffness` and `mass`"),
        ({"stiffness": np.eye(6).tolist()}, "expected either `section` or"),
        ({"stiffness": np.eye(5).tolist(), "mass": MASS.tolist()}, "six rows of six numbers"),
        (
            {"stiffness": (np.eye(6) + np.eye(6, k=1) / 9).tolist(), "mass": MASS.tolist()},
            "a symmetric matrix, found 0.111111 in row 1, column 2 and 0 in row 2, column 1",
        ),
    ],
)
def test_matrices_of_a_station_are_checked(tmp_path, station, message):
    keys = {"table": None, "length": 1.0, "stations": [{"at": 0.0, **station}]}
    with pytest.raises(ValueError, match=message):
        mechanism(tmp_path, **keys)


def test_a_beam_without_table_needs_a_section(tmp_path):
    _, _, problems = in_parts(mechanism(tmp_path, table=None, length=1.0), BodySpecs(tmp_path))
    assert problems == [
        "bodies.blade.section: missing; expected the name of a section, or a `table`"
    ]
