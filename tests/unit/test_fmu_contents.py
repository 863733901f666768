"""Folder `resources` of an FMU: all packages that the run needs, each once."""

from samples.case_samples import HEAD, SOLVER

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.fmu.write import write_contents

ARM = """
[bodies.{name}]
kind = "package"
package = "{file}"
position = [0.0, 0.0, 0.0]
"""
MORE = """
[ground.o]
position = [0.0, 0.0, 0.0]
[signals.z]
kind = "position"
at = "one.{interface}"
component = "y"
[signals.above]
kind = "difference"
of = "z"
run = "other"
[variants.other.bodies.one]
package = "{other}"
[runs.other]
variants = ["other"]
"""


def test_packages_of_other_runs_are_copied_and_shared_ones_once(repository, tmp_path):
    folder = repository / "tests/packages/double-pendulum"
    one, other = folder / "arm.isotropic.vtkhdf", folder / "arm.layup-1.vtkhdf"
    text = "gravity = [0.0, -9.81, 0.0]\n" + HEAD
    text += "".join(ARM.format(name=name, file=one) for name in ("one", "two"))
    text += SOLVER.format(t_end=0.001, step=0.001, more="")
    text += MORE.format(interface="root", other=other)
    (tmp_path / "case.toml").write_text(text)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    run = write_contents(tmp_path / "build/runs/base.json", tmp_path / "resources")
    copies = sorted(file.name for file in (tmp_path / "resources/bodies").iterdir())
    assert copies == ["0-arm.isotropic.vtkhdf", "1-arm.layup-1.vtkhdf"]
    result, _ = execute(read_run(run), progress=False)
    assert "above" in [signal.name for signal in result.signals]
