"""A controller written in Python: only with the option, exact between its instants."""

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER
from samples.coordinate_samples import carriage

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.results import read_result
from plymotion.solver.run.execution import execute, read_run

CODE = """
import numpy as np

def control(t, inputs, memory):
    error = 0.1 - inputs[0]
    memory["sum"] = memory.get("sum", 0.0) + error
    return float(np.clip(40.0 * error + 2.0 * memory["sum"] - 4.0 * inputs[1], -3.0, 3.0))
"""
FORCE = """
[forces.c]
kind = "python_controller"
joint = "rail"
code = { file = "law.py", function = "control" }
inputs = ["x", "joint_rate('rail')"]
sample_time = 0.01
"""


def written(folder, code=CODE, force=FORCE, integrator="radau"):
    """The run file of a case."""
    folder.mkdir(exist_ok=True)
    (folder / "law.py").write_text(code)
    solver = SOLVER.replace("rk8", integrator).format(t_end=0.5, step=0.1, more="")
    (folder / "case.toml").write_text(HEAD + carriage(mass=2.0) + force + solver)
    write_case(load_case(folder / "case.toml"), folder / "build")
    return folder / "build/runs/base.json"


@pytest.mark.parametrize("integrator", ["radau", "rk8"])
def test_exact_between_instants(tmp_path, integrator):
    spec = read_run(written(tmp_path / "case", integrator=integrator))
    for _ in range(2):  # a second run begins with an empty memory
        result, summary = execute(spec, progress=False, allow_python=True)
        found = {s.name: s.values for s in result.signals}
        x = v = total = 0.0
        expected = [0.0]
        for k in range(50):
            error = 0.1 - x
            total += error
            u = np.clip(40 * error + 2 * total - 4 * v, -3, 3)
            x, v = x + 0.01 * v + 0.5e-4 * u / 2.0, v + 0.01 * u / 2.0
            expected += [x] if k % 10 == 9 else []
        np.testing.assert_allclose(found["x"], expected, rtol=1e-9, atol=1e-13)
        assert summary["checks"]["energy_drift_relative"] < 1e-10


def test_refused_without_the_option(tmp_path, capsys):
    """The file is not even executed: it would leave a sign."""
    sign = tmp_path / "sign"
    file = written(tmp_path / "case", f"open({str(sign)!r}, 'w')\n" + CODE)
    assert main(["run", str(file), "--quiet"]) == 2
    assert 'forces.c.code.file = "law.py": runs Python code' in capsys.readouterr().err
    assert not sign.exists()
    assert not (tmp_path / "case/build/base/summary.json").exists()
    assert main(["run", str(file), "--quiet", "--allow-python"]) == 0
    assert sign.exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("return float(", "return ('high', ", "control() at t = 0 s: TypeError"),
        ("inputs[1]", "inputs[2]", "control() at t = 0 s: IndexError"),
        ("error = 0.1", "error = 1 / 0", "ZeroDivisionError"),
        ("return float(", "return float(1e999 + ", "returned inf; expected a finite number"),
        ("def control", "def contrl", '"control": law.py has no such function'),
        ("import numpy as np", "import no_such_module", "ModuleNotFoundError"),
        ("def control", "def control(:", "SyntaxError"),
    ],
)
def test_functions_that_fail(tmp_path, old, new, words):
    code = CODE.replace(old, new)
    assert code != CODE
    spec = read_run(written(tmp_path / "case", code))
    with pytest.raises(InputError) as caught:
        execute(spec, progress=False, allow_python=True)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"law.py"', '"lay.py"', "cannot be read"),
        ('function = "control"', 'source = "x"', "expected `file` and `function` only"),
        ("sample_time = 0.01", "", "forces.c.sample_time: missing"),
        ('"x", ', '"y", ', 'forces.c.inputs.0 = "y": there is no name `y`'),
    ],
)
def test_bad_input(tmp_path, old, new, words):
    with pytest.raises(InputError) as caught:
        written(tmp_path / "case", force=FORCE.replace(old, new))
    assert words in str(caught.value)


def test_modules_and_files_beside_it_are_read_with_it(tmp_path, capsys):
    """An edit of one is noticed; no run has the modules of an earlier one."""
    folder = tmp_path / "case"
    folder.mkdir()
    table = folder / "gains.csv"
    table.write_text("40.0")
    (folder / "gains.py").write_text("from more import P\n")
    (folder / "more.py").write_text(f"P = float(open({str(table)!r}).read())\n")
    code = CODE.replace("import numpy as np", "import numpy as np\nimport gains")
    file = written(folder, code.replace("40.0", "gains.P"))
    words = [str(folder / "case.toml"), "--out", str(tmp_path / "out"), "--no-report", "--quiet"]

    def last():
        assert main([*words, "--allow-python"]) == 0
        x = read_result(tmp_path / "out/base/result.vtkhdf").signals[0].values[-1]
        return x, "up to date" in capsys.readouterr().out

    spec = read_run(file)
    plain = execute(read_run(written(tmp_path / "plain")), progress=False, allow_python=True)[0]
    assert last() == (plain.signals[0].values[-1], False)
    table.write_text("20.0")
    with pytest.raises(InputError, match=r"gains.csv was changed since the case was checked"):
        execute(spec, progress=False, allow_python=True)
    softer, known = last()
    assert softer != plain.signals[0].values[-1]
    assert not known
    (folder / "more.py").write_text("P = 40.0\n")
    assert last() == (plain.signals[0].values[-1], False)
    assert last()[1]


def test_files_that_no_record_shows_are_refused(tmp_path):
    """A second run said "up to date" after an edit of the imported file."""
    folder = tmp_path / "case" / "gains"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("P = 40.0\n")
    for words in ("import gains", "from gains import P"):
        with pytest.raises(InputError, match="imports gains, a folder"):
            written(tmp_path / "case", f"{words}\n{CODE}")
