"""A force element is added by one file after dynamics/forces/contract.py and its entry in table.py.

The recipe is followed in a copy of the solver, which then runs it.
"""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from plymotion.solver.dynamics.forces.contract import N_ELEMENT_ROW
from plymotion.solver.dynamics.forces.table import (
    FIRST_LOAD,
    FORCE_KINDS,
    KINDS,
    MOST_ROWS,
    N_PARAMETER,
    element_rows,
    element_wrench,
)

TOY = '''
"""Magnet between two points: toy of a test, a cubic spring."""

from ...math.arrays import Array
from ...math.compiled import jit
from ...math.triple import dot3, minus3, times3
from ..bodies.motion import place, velocity
from .contract import DAMPING, FORCE, STIFFNESS, ForceKind, Wrench


@jit
def magnet(one: Array, two: Array, parameters: Array, law: float) -> Wrench:
    """The force -k s^3 along the line between the points."""
    d = minus3(place(two), place(one))
    k, square = parameters[0], dot3(d, d)
    return Wrench(times3(-k * square, d), (0.0, 0.0, 0.0), 0.25 * k * square * square, 0.0)


@jit
def magnet_rows(one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Row 0: along the line."""
    d = minus3(place(two), place(one))
    s = dot3(d, d) ** 0.5
    for j in range(3):
        rows[0, j], rows[0, 6 + j] = -d[j] / s, d[j] / s
        rows[0, 3 + j] = rows[0, 9 + j] = 0.0
    rows[0, FORCE] = parameters[0] * s**3
    rows[0, STIFFNESS], rows[0, DAMPING] = 3.0 * parameters[0] * s**2, 0.0


KIND = ForceKind("magnet", ("strength",), magnet, magnet_rows, 1, lambda parameters: [0])
'''
RUN = """
import numpy as np
from plymotion.solver.dynamics.system import assemble, energies
from plymotion.solver.dynamics.tables import ForceTable, MarkerTable, assemble_model, rigid_body
from plymotion.solver.integrators.generic import integrate
from plymotion.solver.integrators.stepping import Radau

body = rigid_body("ball", 1.0, np.zeros(3), np.eye(3))
markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
# The stiff one swings 14 times in its short run; plain NumPy takes 5 ms a step.
for strength, t_end in ((1.0, 0.5), (1e8, 0.005)):
    forces = [ForceTable("m", "magnet", 0, 1, (strength,))]
    model = assemble_model([body], markers, [], forces=forces)
    assert model.plan.newton.place.size == 1
    y0 = np.zeros(14)
    y0[0], y0[3], y0[8] = 1.0, 1.0, 0.5
    atol = np.full(14, 1e-8 if strength == 1.0 else 0.1)
    made = Radau(model, 0.0, y0, t_end, rtol=1e-6, atol=atol)
    done = integrate(made, [0.0, t_end])
    assert done.status == "finished", done.message
    total = [energies(model, assemble(model, 0.0, y), y).sum() for y in done.y]
    if strength == 1.0:
        assert abs(total[1] - total[0]) < 1e-5, total
        assert abs(done.y[1, 0] - 1.0) > 0.05
print("done")
"""


def test_a_toy_element_runs(repository, tmp_path):
    package = tmp_path / "plymotion"
    package.mkdir()
    shutil.copy(repository / "plymotion/__init__.py", package)
    solver = package / "solver"
    shutil.copytree(repository / "solver", solver, ignore=shutil.ignore_patterns("__pycache__"))
    folder = solver / "dynamics/forces"
    (folder / "magnet.py").write_text(TOY)
    table = (folder / "table.py").read_text()
    for old, new in (
        ("from .spring import", "from . import magnet as magnet_file\nfrom .spring import"),
        ("    bushing_file.KIND,\n", "    bushing_file.KIND,\n    magnet_file.KIND,\n"),
        (
            "    if kind == 3:\n        return force(",
            "    if kind == 3:\n"
            "        return magnet_file.magnet(one, two, parameters, law)\n"
            "    if kind == 4:\n        return force(",
        ),
        (
            "        bushing_rows(one, two, parameters, rows)\n",
            "        bushing_rows(one, two, parameters, rows)\n"
            "    elif kind == 3:\n"
            "        magnet_file.magnet_rows(one, two, parameters, rows)\n",
        ),
    ):
        assert old in table
        table = table.replace(old, new, 1)
    (folder / "table.py").write_text(table)
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        env={**os.environ, "PYTHONPATH": str(tmp_path), "PLYMOTION_COMPILED": "0"},
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "done"


def _marker(rng):
    """A row of bodies/motion.py with axes of a rotation."""
    motion = rng.normal(size=24)
    motion[3:12] = np.linalg.qr(rng.normal(size=(3, 3)))[0].ravel()
    if np.linalg.det(motion[3:12].reshape(3, 3)) < 0.0:
        motion[3:12] *= -1.0
    return motion


@pytest.mark.parametrize("kind", FORCE_KINDS, ids=lambda k: k.name)
def test_every_branch_of_the_table_leads_to_its_kind(kind):
    rng = np.random.default_rng(1)
    one, two = _marker(rng), _marker(rng)
    parameters = rng.uniform(0.5, 2.0, N_PARAMETER)
    number = KINDS[kind.name]
    assert FORCE_KINDS[number] is kind
    found = element_wrench(number, one, two, parameters, 0.7)
    assert found == kind.wrench(one, two, parameters, 0.7)
    assert (number >= FIRST_LOAD) == kind.from_outside
    in_use = kind.rows_in_use(parameters)
    assert set(in_use) <= set(range(kind.most_rows))
    if kind.rows is not None:
        rows = [np.full((MOST_ROWS, N_ELEMENT_ROW), np.nan) for _ in range(2)]
        element_rows(number, one, two, parameters, rows[0])
        kind.rows(one, two, parameters, rows[1])
        np.testing.assert_array_equal(*rows)
        assert np.isfinite(rows[0][: kind.most_rows]).all()
        assert (kind.rows_in_use([0.0] * N_PARAMETER)) == []
    else:
        assert kind.most_rows == len(in_use) == 0
