"""Long tables: packed in the run file, the same motion, refused where a user writes them packed."""

import json
import tracemalloc

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER
from samples.coordinate_samples import carriage, run

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.laws import LONG, read_columns
from plymotion.solver.math.rows import PREFIX, column, packed
from plymotion.solver.run.execution import execute, read_run

LOAD = (
    '[forces.push]\nkind = "force"\nat = "car.a"\ndirection = [1.0, 0.0, 0.0]\n'
    'law = {{ table = {{ {table} }} }}\n'
)  # fmt: skip
W, SIZE = 10.0, 3.0


def written(folder, rows):
    """A file of SIZE sin(W t) over 1 s."""
    t = np.linspace(0.0, 1.0, rows)
    file = folder / "load.csv"
    np.savetxt(file, np.column_stack([t, SIZE * np.sin(W * t)]), "%.17g", ",")
    return file


@pytest.mark.parametrize("rows", [LONG - 1, 2 * LONG])
def test_the_motion_is_that_of_the_closed_form(tmp_path, rows):
    """x'' = F sin(w t) from rest: x = F (w t - sin(w t)) / w^2; short tables stay lists."""
    written(tmp_path, rows)
    text = carriage(LOAD.format(table='file = "load.csv"'))
    t, history, _ = run(tmp_path, text, 1.0, 0.1, 'integrator = "radau"')
    exact = SIZE * (W * t - np.sin(W * t)) / W**2
    np.testing.assert_allclose(history["x"], exact, atol=2e-5)


def test_a_run_file_holds_the_numbers_and_its_seal_their_digest(tmp_path):
    """Read with the seal and, after an edit, without it; a damaged column is refused."""
    rows = 3 * LONG
    written(tmp_path, rows)
    case = tmp_path / "case.toml"
    solver = SOLVER.format(t_end=0.1, step=0.1, more="")
    case.write_text(HEAD + carriage(LOAD.format(table='file = "load.csv"')) + solver)
    assert main(["check", str(case), "--out", str(tmp_path / "out")]) == 0
    file = next((tmp_path / "out").rglob("runs/base.json"))
    text = file.read_text()
    assert text.count(PREFIX) == 2
    assert len(text) < 2 * rows * 11 + 20_000
    spec = read_run(file)
    values = column(spec.mechanism.forces["push"].law.table.values)
    t = np.linspace(0.0, 1.0, rows)
    np.testing.assert_array_equal(values, SIZE * np.sin(W * t))

    edited = json.loads(text)
    edited["mechanism"]["solver"] |= {"t_end": 0.05, "output_step": 0.05}
    file.write_text(json.dumps(edited))
    again = read_run(file)
    np.testing.assert_array_equal(column(again.mechanism.forces["push"].law.table.values), values)
    _, summary = execute(again, progress=False)
    assert summary["completed"]

    edited["mechanism"]["forces"]["push"]["law"]["table"]["values"] = PREFIX + "?"
    file.write_text(json.dumps(edited))
    with pytest.raises(InputError, match=r"table\.values.*packed column"):
        read_run(file)


def test_a_packed_column_of_a_user_is_none(tmp_path):
    column_text = packed(np.zeros(4))
    case = tmp_path / "case.toml"
    text = carriage(LOAD.format(table=f'times = [0.0, 1.0], values = "{column_text}"'))
    case.write_text(HEAD + text + SOLVER.format(t_end=0.1, step=0.1, more=""))
    with pytest.raises(InputError, match=r"table\.values"):
        load_case(case)


def test_memory_of_reading_is_that_of_the_numbers(tmp_path):
    """As lists of numbers and lines, a row took 250 bytes."""
    rows = 2 * LONG
    file = written(tmp_path, rows)
    tracemalloc.start()
    columns = read_columns(file)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(columns[0]) == len(columns[1])
    assert peak < 80 * rows
