"""`[rotor]` of a case: messages with file, key and value; wind from a file."""

import re
import tomllib

import numpy as np
import pytest
from samples.rotor_samples import write_rotor
from samples.segment_samples import run_of

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case, source_files
from plymotion.solver.inputs.case.tables.schema import mechanism_of
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run


def _refused(file, words):
    with pytest.raises(InputError) as found:
        load_case(file)
    assert str(file) in str(found.value)
    assert re.search(words, str(found.value)), str(found.value)


def test_a_missing_polar(tmp_path):
    file = write_rotor(tmp_path, polar_name="thinn")
    _refused(file, r'rotor\.table = "aero.csv" row 1: polar = "thinn": no such polar.*thin')


def test_a_polar_that_ends_early(tmp_path):
    file = write_rotor(tmp_path)
    lines = (tmp_path / "polars.csv").read_text().splitlines()
    (tmp_path / "polars.csv").write_text("\n".join(lines[:-10]))
    _refused(file, r"rotor\.polars\.thin\.alpha_deg: from -180 to 130; expected -180 to 180")


def test_a_wind_file_that_ends_early(tmp_path):
    (tmp_path / "wind.csv").write_text("time,speed,direction\n0,8,0\n0.5,9,0\n")
    file = write_rotor(tmp_path, 'file = "wind.csv"')
    _refused(file, r'rotor\.wind\.file = "wind.csv": ends at 0.5 s; expected up to .*t_end = 1 s')
    file = write_rotor(tmp_path, "speed = { table = { times = [0, 0.7], values = [8, 9] } }")
    _refused(file, r"rotor\.wind\.speed\.table: ends at 0.7 s; expected up to solver\.t_end = 1 s")


@pytest.mark.parametrize(
    ("wind", "words"),
    [
        ('file = "none.csv"', r"rotor\.wind.*none\.csv: cannot be read"),
        ("", r"rotor\.wind.*expected either `speed` or `file`"),
        ("speed = { constant = 9.0 }\nup = [1.0, 0.0, 0.0]", r"expected a right angle to `up`"),
        ("speed = { expression = 'joint(\"shaft\")' }", r"rotor\.wind\.speed\.expression"),
    ],
)
def test_wrong_wind(tmp_path, wind, words):
    _refused(write_rotor(tmp_path, wind), words)


def test_a_line_that_is_not_numbers(tmp_path):
    (tmp_path / "wind.csv").write_text("time,speed,direction\n0,8,0\n1,fast,0\n")
    words = (
        r"wind\.csv line 3: expected numbers for times, speeds, directions_deg, found '1,fast,0'"
    )
    _refused(write_rotor(tmp_path, 'file = "wind.csv"'), words)


def test_columns_of_the_wind_in_another_order(tmp_path):
    (tmp_path / "wind.csv").write_text("Speed [m/s],Time [s],Direction\n0,8,0\n1,9,0\n")
    words = r"wind\.csv: columns 'Speed .*; expected times, speeds, directions_deg in this order"
    _refused(write_rotor(tmp_path, 'file = "wind.csv"'), words)


def test_missing_places(tmp_path):
    file = write_rotor(tmp_path)
    text = file.read_text()
    file.write_text(text.replace('blades = ["b0"', 'blades = ["hub"'))
    _refused(file, r'rotor\.blades: hub = "a0": no such interface')
    file.write_text(text.replace('hub = "hub.centre"', 'hub = "hub.center"'))
    _refused(file, r'rotor\.hub = "hub.center".*centre')
    file.write_text(text.replace("[rotor.wind]", "[other.wind]").replace("[rotor]", "[other]"))
    _refused(file, r"other: unknown key|signals")


def test_wind_from_a_file_turns_and_rises(tmp_path):
    """The run holds the rows of the file; the file is one of the case's sources."""
    (tmp_path / "wind.csv").write_text("time [s],speed,direction\n0,8,0\n1,10,0\n2,10,30\n")
    solver = 't_end = 2.0\noutput_step = 0.25\nintegrator = "rk5"\nrtol = 1e-4'
    file = write_rotor(tmp_path, 'file = "wind.csv"', solver=solver)
    case = load_case(file)
    names = {path.name for path in source_files(case)}
    assert {"wind.csv", "aero.csv", "polars.csv"} <= names
    write_case(case, tmp_path / "build")
    for name in names - {"case.toml"}:
        (tmp_path / name).unlink()
    result, _ = execute(read_run(tmp_path / "build/runs/all.json"), progress=False)
    thrust = next(s.values for s in result.signals if s.name == "thrust")
    assert (np.diff(thrust[:5]) > 0.0).all()
    assert thrust[-1] < 0.97 * thrust[4]


def test_a_blade_in_segments_has_the_loads_of_one_body(tmp_path):
    """Curved and twisted, stiff: the axes of its segments are not those of the blade."""
    file, found = write_rotor(tmp_path), []
    given = {k: v for k, v in tomllib.loads(file.read_text()).items()
             if k not in ("format", "title", "runs")}  # fmt: skip
    rotor = mechanism_of(given, tmp_path)[0].model_dump()["rotor"]
    for segments in (1, 3):
        case = tomllib.loads(file.read_text())
        table = {key: case[key] for key in ("ground", "joints", "signals", "bodies")}
        for name in ("b0", "b1", "b2"):
            body = case["bodies"][name]
            at = {k: {"at": v["position"][0] / 20.0} for k, v in body["interfaces"].items()}
            table["bodies"][name] = {
                "kind": "beam", "section": "s", "material": "m", "elements": 30,
                "line": {"points": [[0.0, 0.0, 0.0], [10.0, 0.5, 0.3], [19.9, -0.4, -1.0]]},
                "twist_deg": [[0.0, 20.0], [1.0, -5.0]], "segments": segments, "interfaces": at,
                "modes": [{"kind": "lowest", "count": 2}] if segments == 1 else [],
                "rotation_deg": body["rotation_deg"],
            }  # fmt: skip
        table["solver"] = {"t_end": 0.01, "output_step": 0.01, "start": "quasi-static"}
        table["rotor"] = rotor | {"table": None, "polar_table": None}
        result, summary = execute(run_of(table, (1e12 * np.eye(6), np.eye(6))), progress=False)
        assert summary["completed"], summary["message"]
        found.append([signal.values[0] for signal in result.signals])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)
