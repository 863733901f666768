"""`[rotor]` of a case: messages with file, key and value; wind from a file."""

import re

import numpy as np
import pytest
from samples.rotor_samples import write_rotor

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case, source_files
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
