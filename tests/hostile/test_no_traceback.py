"""Odd input ends in words, in time, and with an exit code that says whose fault it is."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.results import ResultError, read_result, relative_balance
from plymotion.solver.studies.exit_codes import DEFECT

BALL = HEAD + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
CASE = BALL + SOLVER.format(t_end=0.1, step=0.01, more="")
SIGNAL = '[signals.x]\nkind = "position"\nat = "ball.c"\ncomponent = "x"\n'


def _check(folder: Path, text: str | bytes) -> int:
    file = folder / "case.toml"
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return main(["check", str(file), "--out", str(folder / "out")])


WRONG = {
    "nested": ("x = " + "[" * 500 + "]" * 500 + "\n" + CASE, "nested too deep"),
    "digits": (CASE.replace("mass = 1.0", "mass = " + "9" * 5000), "not valid TOML: .*4300 digits"),
    "a million dots": ("x" + ".x" * 1_000_000 + " = 1\n" + CASE, "nested too deep"),
    "dots": ("x" + ".x" * 2_000 + " = 1\n" + CASE, "nested too deep; expected 100 levels"),
    "hexadecimal digits": (
        CASE.replace("mass = 1.0", "mass = 0x" + "f" * 5000),
        "bodies.ball.mass = a number of thousands of digits: .*valid number",
    ),
    "long name": (CASE + f"[runs.{'r' * 240}]\n", "runs.r.* at most 100 characters"),
    "true": (CASE.replace("mass = 1.0", "mass = true"), "bodies.ball.mass = True: .*valid number"),
    "quoted": (CASE.replace("mass = 1.0", 'mass = "1"'), 'bodies.ball.mass = "1": .*valid number'),
    "inertia": (
        CASE.replace("[0.0, 0.0, 0.1]]", "[0.0, 0.0, 10.0]]"),
        r"bodies.ball.inertia = .*: no body has principal moments 0.1, 0.1, 10 kg m2",
    ),
    "coarse": (
        CASE + "[coarse.solver]\nt_endd = 1\n",
        r"solver.t_endd: unknown key; did you mean 't_end'\? \(in \[coarse\]\)",
    ),
    "late output": (
        CASE.replace("output_step = 0.01", "output_step = 1.0"),
        "solver.output_step = 1: expected at most solver.t_end = 0.1 s",
    ),
    "outputs": (
        CASE.replace("output_step = 0.01", "output_step = 1e-12"),
        r"output_step = 1e-12: 1e\+11 outputs up to t_end = 0.1 s, which take at least 1.04e\+13 "
        "bytes; expected at most solver.most_outputs = 10000000",
    ),
    "endless": (CASE.replace("t_end = 0.1", "t_end = 1e308"), r"output_step = 0.01: inf outputs"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_told(tmp_path, capsys, name):
    text, words = WRONG[name]
    assert _check(tmp_path, text) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1, told
    assert str(tmp_path / "case.toml") in told
    assert re.search(words, told), told
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are text there")
@pytest.mark.parametrize("place", ["case", "out", "current"])
def test_a_path_that_is_no_text_is_told(tmp_path, capsys, monkeypatch, place):
    """In files of results, paths are UTF-8."""
    odd = tmp_path / os.fsdecode(b"caf\xe9")
    odd.mkdir()
    case = (odd if place == "case" else tmp_path) / "case.toml"
    case.write_text(CASE)
    monkeypatch.chdir(odd if place == "current" else tmp_path)
    with pytest.raises(SystemExit) as end:
        main(["run", str(case), "--out", str(odd if place == "out" else tmp_path / "out")])
    assert end.value.code == 2
    assert r"caf\udce9" in (told := capsys.readouterr().err)
    assert told.endswith(": expected a path whose bytes are UTF-8\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="links need a right there")
def test_a_loop_of_links_is_told(tmp_path, capsys):
    assert _check(tmp_path, CASE) == 0
    (tmp_path / "out/base").symlink_to("loop")
    (tmp_path / "out/loop").symlink_to("base")
    assert main(["run", str(tmp_path / "out/runs/base.json"), "--quiet"]) == 2
    told = capsys.readouterr().err
    assert re.search("out/base: (File exists|Too many levels of symbolic links)", told), told


def test_limit_of_outputs_may_be_raised(tmp_path, capsys):
    many = CASE.replace("output_step = 0.01", "output_step = 5e-9")
    assert _check(tmp_path, many) == 2
    assert _check(tmp_path, many.replace("[solver]", "[solver]\nmost_outputs = 20_000_001")) == 0


def test_an_edited_run_file_is_checked_for_outputs(tmp_path, capsys):
    assert _check(tmp_path, CASE) == 0
    file = tmp_path / "out/runs/base.json"
    file.write_text(file.read_text().replace('"output_step": 0.01', '"output_step": 1e-12'))
    assert main(["run", str(file), "--quiet"]) == 2
    assert "base.json: solver.output_step = 1e-12: 1e+11 outputs" in capsys.readouterr().err


def test_byte_order_mark(tmp_path):
    assert _check(tmp_path, b"\xef\xbb\xbf" + CASE.encode()) == 0


@pytest.mark.parametrize("value", ["1e308", "1.7e308", "5e-324", "1e-300"])
@pytest.mark.parametrize("key", ["mass = 1.0", "t_end = 0.1", "rtol = 1e-10", "max_step = 1.0"])
def test_extreme_numbers(tmp_path, capsys, key, value):
    """An end within seconds, in words."""
    name = key.partition(" ")[0]
    text = CASE.replace("[runs.base]", "max_step = 1.0\n[runs.base]").replace("rk8", "radau")
    text = text.replace(key, f"{name} = {value}")
    code = _check(tmp_path, text)
    if code == 0:
        code = main(["run", str(tmp_path / "out/runs/base.json"), "--quiet"])
    assert code in (0, 2, 3), capsys.readouterr().err


@pytest.mark.parametrize(
    "text",
    [
        *("[]", "7", '"x"', "null", "", "{", "[" * 100_000, "{}", "9" * 5000),
        *('{"runs": {}}', '{"runs": []}', '{"runs": {"../x": 1}}'),
        *('{"runs": {"a": 1}, "figures": 7}', '{"runs": {"a": 1}, "figures": {"f": {}}}'),
    ],
)
@pytest.mark.parametrize("command", ["report", "run", "sweep"])
def test_malformed_json(tmp_path, capsys, command, text):
    file = tmp_path / "case.json"
    file.write_text(text)
    assert main([command, str(tmp_path if command == "report" else file)]) == 2
    told = capsys.readouterr().err
    assert str(tmp_path) in told
    assert told.count("\n") == 1


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("packages", []),
        ("packages", {"ball": 7}),
        ("packages", {"ball": {"file": 7}}),
        ("packages", {"ball": {"file": "a\0b"}}),
        ("packages", {"no": {"file": "x.vtkhdf"}}),
        ("mechanism", []),
        ("mechanism", {}),
        ("case", None),
    ],
)
def test_run_files_of_another_form(tmp_path, capsys, key, value):
    assert _check(tmp_path, CASE) == 0
    file = tmp_path / "out/runs/base.json"
    table = json.loads(file.read_text())
    file.write_text(json.dumps({**table, key: value}))
    assert main(["run", str(file), "--quiet"]) in (0, 2)
    told = capsys.readouterr().err
    assert "defect" not in told
    assert not told or str(file) in told


def _run(folder: Path, text: str) -> Path:
    assert _check(folder, text) == 0
    assert main(["run", str(folder / "out/runs/base.json"), "--quiet"]) == 0
    return folder / "out/base"


@pytest.mark.parametrize("version", [np.inf, np.nan, 7.0, "1", [1, np.inf], [1, 2, 3]])
def test_version_of_a_file(tmp_path, version):
    file = _run(tmp_path, CASE) / "result.vtkhdf"
    with h5py.File(file, "r+") as opened:
        del opened.attrs["format_version"]
        opened.attrs["format_version"] = version
    with pytest.raises(ResultError, match=r"format_version: expected \[major, minor\]"):
        read_result(file)


def test_formulas_in_titles_are_words(tmp_path):
    pytest.importorskip("matplotlib")
    odd = r"$\foo{$ <b> & ^_"
    text = CASE.replace('title = "sample"', f"title = '{odd}'").replace("[runs.base]", SIGNAL)
    text += f"[runs.base]\ntitle = '{odd}'\n"
    text += f"[figures.f]\ntitle = '{odd}'\nsignal = 'x'\nruns = ['base']\n"
    _run(tmp_path, text)
    assert main(["report", str(tmp_path / "out"), "--figures"]) == 0
    assert "&lt;b&gt; &amp;" in (tmp_path / "out/report.html").read_text()
    assert (tmp_path / "out/f.png").is_file()


@pytest.mark.parametrize(
    "error", [RecursionError("deep"), MemoryError(), np.linalg.LinAlgError("x"), KeyError("k")]
)
@pytest.mark.parametrize("command", ["check", "run"])
def test_the_last_resort(tmp_path, capsys, monkeypatch, error, command):
    def fails(*_, **__):
        raise error

    write_case(load_case(_written(tmp_path)), tmp_path / "out")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setattr("plymotion.solver.inputs.case.load.checked_case", fails)
    monkeypatch.setattr("plymotion.solver.run.execution.prepare", fails)
    words = [str(tmp_path / "case.toml")]
    if command == "run":
        words = [str(tmp_path / "out/runs/base.json"), "--quiet"]
    assert main([command, *words]) == DEFECT == 70
    told = capsys.readouterr().err
    (file,) = tmp_path.glob("plymotion-traceback-*.txt")
    assert told.count("\n") == 1
    assert str(file) in told
    assert type(error).__name__ in told
    assert "in fails" in file.read_text()


def _written(folder: Path) -> Path:
    (folder / "case.toml").write_text(CASE)
    return folder / "case.toml"


def test_a_long_run_tells_where_it_is(tmp_path):
    """A drive of 1e12 rad/s without a terminal."""
    driven = (
        "[ground.O]\nposition = [0.0, 0.0, 0.0]\n[joints.h]\nkind = 'revolute'\n"
        "between = ['ground.O', 'ball.c']\naxis = [0.0, 0.0, 1.0]\ndrive = { speed = 1e12 }\n"
    )
    assert _check(tmp_path, CASE.replace("[solver]", driven + "[solver]")) == 0
    command = [sys.executable, "-m", "plymotion", "run", str(tmp_path / "out/runs/base.json")]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=os.environ | {"PLYMOTION_COMPILED": "0"}
    )
    try:
        assert re.match(r"base: t = \S+ of 0.1 s, \d+ steps, \d+ s", process.stderr.readline())
    finally:
        process.terminate()
        process.communicate(timeout=60)
    assert process.returncode == 143


def test_rest_is_no_energy_drift():
    """Balance of a mechanism that hangs still: nothing but rounding."""
    rounding = 5e-16 * np.array([0.0, 1.0, -1.0, 2.0])
    still = {
        "kinetic": 1e-33 * np.ones(4),
        "strain": np.zeros(4),
        "potential": -4.9 + rounding,
        "drive_work": np.zeros(4),
    }
    assert not relative_balance(still).any()
    moving = still | {"potential": -4.9 + np.array([0.0, 0.1, 0.2, 0.1])}
    assert np.abs(relative_balance(moving)).max() == pytest.approx(1.0)
