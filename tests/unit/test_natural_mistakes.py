"""Natural mistakes in the starters of `plymotion new`: each message leads to what is meant."""

import shutil
from pathlib import Path

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.commands.bodies.description_command import tell_failure
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.common.text_file import read_toml
from plymotion.solver.inputs.shell_specification import shell_spec
from plymotion.solver.workers.description_results import Entry, Made

STARTERS = Path(__file__).parents[2] / "solver/commands/starters"
PUSH = '\n[forces.push]\nkind = "force"\nat = "arm.tip"\n'
STRENGTH = '\n[signals.least]\nkind = "strength_ratio"\nbody = "{}"\n'
SWEEP = '\n[sweeps.a]\nrun = "base"\n[sweeps.a.vary]\n'
STIFF = """
[variants.stiff.bodies.arm]
kind = "rigid"
mass = 1
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
interfaces = { root = { position = [0, 0, 0] }, tip = { position = [0.5, 0, 0] } }
[runs.stiff]
variants = ["stiff"]
"""
MISTAKES = [
    ("robot-arm", 'quantity = "moment"', 'quantity = "torque"', "did you mean 'moment'?"),
    (
        "arm",
        "length = 0.5",
        "length = 0.5\nsecond_order = true",
        "unknown key; did you mean 'solver.geometric_stiffening'?",
    ),
    (
        "arm",
        "length = 0.5",
        "length = 0.5\ngeometric_stiffening = true",
        "unknown key; did you mean 'solver.geometric_stiffening'?",
    ),
    (
        "arm",
        "[runs.base]",
        '[signals.turn]\nkind = "joint"\njoint = "base"\ncomponent = "angle"\n[runs.base]',
        "unknown key; did you mean 'coordinate'?",
    ),
    (
        "panel",
        "damping_ratio",
        "segments = 4\ndamping_ratio",
        "segments: unknown key of shell; beam",
    ),
    ("arm", "E1 = 129.2e9", "E1 = 135", r"E1 = 135: expected Pa, as E2 = 9.4e+09: in GPa?"),
    ("arm", 'kind = "orthotropic"', 'kind = "isotropic"', "E1, E2, E3, G12, G13, G23, nu12, nu13"),
    ("arm", "length = 0.5", 'length = 0.5\ntheory = "bernoulli"', "did you mean 'classical'?"),
    ("arm", 'kind = "revolute"', 'kind = "hinge"', "did you mean 'revolute'?"),
    ("arm", 'shape = "rectangle"', 'shape = "pipe"', "did you mean 'tube'?"),
    ("arm", "axis = [0.0, 0.0, 1.0]", 'axis = "z"', "list of 3 numbers, such as [0.0, 0.0, 1.0]"),
    ("arm", "output_step = 0.005", "dt = 0.005", "did you mean 'output_step'?"),
    ("arm", "output_step = 0.005", "", "missing; expected a value: interval of the results [s]"),
    ("arm", "rho = 1550.0", "density = 1550.0", "did you mean 'rho'?"),
    ("arm", "t_end = 1.5", 't_end = "1.5"', "valid number [s], without quotes"),
    ("arm", '"arm.root"', '"arm"', 'or "ground.POINT", such as arm.root, arm.tip'),
    ("arm", '"ground.base"', '"ground"', "such as ground.base"),
    ("arm", 'tip = { at = "end" }', 'tip = { at = "tip" }', "'start' or 'end' or a valid number"),
    ("arm", "drive = {", "drive = 3.14 # {", "drive = 3.14: expected a table, such as { speed"),
    (
        "arm",
        "[runs.base]",
        f"{PUSH}value = 3\n[runs.base]",
        "expected a table [forces.push.law], such",
    ),
    ("arm", "[runs.base]", f"[loads.a]\nat = 1\n{PUSH}[runs.base]", "did you mean 'forces'?"),
    (
        "arm",
        "[runs.base]",
        f"[runs.base]\n{SWEEP}L = [1, 2]",
        'expected a dotted key, such as "bodies',
    ),
    (
        "arm",
        "[runs.base]",
        STRENGTH.format("arm") + "[runs.base]",
        'least.body = "arm": no material of it has strengths; expected a table `strength` in [mat',
    ),
    (
        "arm",
        "[runs.base]",
        f"{STIFF}{STRENGTH.format('arm')}[runs.base]",
        "this one is rigid (run stiff, variant stiff; a signal of a body that a variant replaces: "
        "[variants.NAME.signals])",
    ),
    ("arm", "[runs.base]", "[run.base]", "run: unknown key; did you mean 'runs'?"),
    ("panel", "[runs.base]", STRENGTH.format("panel") + "[runs.base]", "`strength` in [materials."),
    (
        "panel",
        "inertia = [[5.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 5.0]]",
        "inertia = [5.0, 5.0, 5.0]",
        "inertia: expected a list of lists: 3x3 inertia about the mass centre",
    ),
    ("arm", "drive = {", "motor = {", "shoulder.motor: unknown key; did you mean 'drive'?"),
    ("arm", "gravity =", "g =", "g: unknown key; did you mean 'gravity'?"),
    ("arm", 'at = "arm.tip"', 'body = "arm"', "payload.body: unknown key; did you mean 'at'?"),
    ("arm", "[bodies.arm]", '[[bodies]]\nname = "arm"', "expected a table"),
    ("arm", "length = 0.5", 'length = "M"', "an expression of [parameters]: there is no name `M`"),
    ("arm", "length = 0.5", 'length = "0.5 m"', 'length = "0.5 m": value should be a valid number'),
    ("arm", 'kind = "revolute"', 'free = "rz"', 'some of x, y, z, rx, ry, rz in a list: ["rz"]'),
    ("arm", 'kind = "deflection"', 'kind = "coordinate"', "did you mean 'joint'?"),
    ("arm", 'kind = "deflection"', 'kind = "torque"', "did you mean 'reaction'?"),
    ("arm", 'kind = "deflection"', 'kind = "strain"', "did you mean 'ply_stress'?"),
    ("arm", "component =", "direction =", "tip_bending.direction: unknown key; did you mean 'comp"),
    (
        "arm",
        "smooth_step = {",
        "velocity = 3, a = {",
        "drive.velocity: unknown key; did you mean 'spe",
    ),
    ("arm", "between =", "child =", "shoulder.child: unknown key; did you mean 'between'?"),
    ("arm", '"ground.base"', '"world.base"', 'there is no body "world"; known: arm, ground'),
    ("arm", "t_end", "end_time", "solver.end_time: unknown key; did you mean 't_end'?"),
    ("arm", "t_end", 'integrator = "ODE45"\nt_end', "did you mean 'rk5'?"),
    (
        "arm",
        "[runs.base]",
        "[runs.base]\nt_end = 2",
        "t_end: expected it in a variant, [variants.NAME.s",
    ),
    (
        "arm",
        "[runs.base]",
        "[runs.base]\nmasses = 2",
        "masses: expected it in a variant, [variants.NAME]",
    ),
    (
        "arm",
        "[runs.base]",
        f'[runs.base]\n{SWEEP}"gravity.1" = 30',
        "expected a list, such as [0, 30]",
    ),
    (
        "arm",
        "[runs.base]",
        f'[runs.base]\n{SWEEP}"bodies.arm.material" = ["carbon"]',
        "expected numbers; words, such as names, are changed by [variants]",
    ),
    (
        "arm",
        "[runs.base]",
        f'[runs.base]\n{SWEEP}"gravity.1" = {{ start = 0, stop = 9, num = 3 }}',
        "num: unknown key; did you mean 'count'?",
    ),
    (
        "robot-arm",
        "[runs.flexible]",
        f'[runs.base]\n{SWEEP}"sections.tube.laminates.wall.angles_deg.0" = [0, 30]',
        'follows a colon, "sections.tube:laminates.wall.angles_deg.0"',
    ),
]

STUDY = """
[design.parameters.a]
of = ["bodies.arm.ply_angle_deg"]
kind = "angle"
bounds = [-90, 90]
[design.studies.s]
run = "base"
minimise = { signal = "tip_bending", of = "rms" }
"""
ROTOR = """
[rotor]
hub = "hub.centre"
axis = [1, 0, 0]
blades = ["arm"]
wind = { speed = { constant = 10 } }
"""
FLOOR = """
[forces.floor]
kind = "contact"
between = ["ground.base", "arm.tip"]
stiffness = 1e5
"""
PID = """
[forces.motor]
kind = "controller"
joint = "shoulder"
proportional = 10
setpoint = "1.0"
"""
BRISTLE = """
[forces.motor]
kind = "bristle_friction"
joint = "shoulder"
coulomb = 1
bristle_damping = 1
stiffness = 1e5
"""
# In new tables: the table, what is wrong in it, and the message.
NEW = [
    (STUDY, "minimise", "objective", "did you mean 'minimise'?"),
    (STUDY, "minimise", "minimize", "did you mean 'minimise'?"),
    (
        STUDY,
        "bounds = [-90, 90]",
        "max = 90",
        "parameters.a.max: unknown key; did you mean 'bounds'",
    ),
    (STUDY, '"rms"', '"mean"', "did you mean 'rms'?"),
    (STUDY, "[-90, 90]", "[90, -90]", "a.bounds = [90.0, -90.0]: expected the lower bound first"),
    (STUDY, ', of = "rms" }', " }", 'expected a key `of`, such as of = "rms"'),
    (STUDY, "signal =", "weight =", "minimise.weight: unknown key; did you mean 'mass'?"),
    (
        STUDY,
        "run =",
        'subject_to = [{ strength = "arm", min = 1 }]\nrun =',
        'strength = "arm": no material of it has strengths; expected a table `strength` in [mat',
    ),
    (STUDY, "run =", "constraints = []\nrun =", "did you mean 'subject_to'?"),
    (STUDY, "run =", "algorithm = 1\nrun =", "did you mean 'driver'?"),
    (STUDY, "run =", "subject_to = { max = 1 }\nrun =", "expected a list, such as [{ ... }]"),
    (STUDY, "run =", "subject_to = [{ mass = true }]\nrun =", "in quotes: name of a body"),
    (STUDY, '["bodies.arm.ply_angle_deg"]', '"bodies.arm.x"', 'expected a list: ["bodies.arm.x"]'),
    (STUDY, "arm.ply_angle_deg", "arm.angle", "did you mean 'ply_angle_deg'?"),
    (ROTOR, "axis", 'table = "a.csv"\naxis', 'rotor.table = "a.csv": '),
    (ROTOR, "{ constant = 10 }", "10", "expected a table, such as { constant = ... }"),
    (FLOOR, "between", "mu = 0.3\nbetween", "did you mean 'coefficient'?"),
    (FLOOR, "between", "friction = 0.3\nbetween", "did you mean 'coefficient'?"),
    (FLOOR, "between", "damping = 3\nbetween", "did you mean 'restitution'?"),
    (FLOOR, "between", "normal = [0, 0, 1]\nbetween", "did you mean 'axis'?"),
    (FLOOR, '"contact"', '"plane"', "did you mean 'contact'?"),
    (FLOOR, "between", 'axis = "z"\nbetween', "expected a list of 3 numbers, such as [0.0"),
    (ROTOR, "blades", 'table = "a.csv"\nblades', "a.csv: cannot be read"),
    (ROTOR, "axis", 'table = "a.csv"\naxi', "rotor.axis: missing"),  # beside the missing file
    (ROTOR, '"arm"', '"arm", "arm"', "blades = ['arm', 'arm']: expected each blade once"),
    (STUDY, "run =", 'subject_to = [{ mass = "arm", min = 2, max = 1 }]\nrun =', "at most max = 1"),
    (STUDY, '"rms"', '"rms", from = 60', "studies.s.minimise.from = 60: expected at most solver.t"),
    (PID, "proportional", "kp", "did you mean 'proportional'?"),
    (PID, "setpoint", "target", "did you mean 'setpoint'?"),
    (
        BRISTLE,
        "bristle_damping",
        "damping",
        "motor.damping: unknown key; did you mean 'bristle_damping'?",
    ),
]
MISTAKES += [
    ("arm", "[runs.base]", f"{table.replace(old, new, 1)}[runs.base]", message)
    for table, old, new, message in NEW
]


@pytest.mark.parametrize(("starter", "old", "new", "message"), MISTAKES)
def test_the_message_leads_to_what_is_meant(
    tmp_path: Path, starter: str, old: str, new: str, message: str
) -> None:
    shutil.copytree(STARTERS / starter, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "case.toml"
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as error:
        load_case(file)
    assert message in str(error.value)


def test_a_list_of_wrong_words_is_no_wrong_word(tmp_path: Path) -> None:
    """Items of a list have errors of their own, without one of the other form of the key."""
    shutil.copytree(STARTERS / "panel", tmp_path, dirs_exist_ok=True)
    file = tmp_path / "panel.toml"
    file.write_text(file.read_text().replace('fixed = "all"', 'fixed = ["x"]'))
    with pytest.raises(InputError) as error:
        shell_spec(read_toml(file, "shell description"), file)
    assert str(error.value).startswith(
        f"{file}: supports.root.fixed.0 = \"x\": value should be 'ux'"
    )
    assert "symmetry" not in str(error.value)


def test_the_only_coordinate_of_a_joint_needs_no_name(tmp_path: Path) -> None:
    """As in forces; a joint with several coordinates asks for one."""
    shutil.copytree(STARTERS / "pendulum", tmp_path, dirs_exist_ok=True)
    file = tmp_path / "case.toml"
    text = file.read_text().replace('coordinate = "angle"', "")
    file.write_text(text)
    assert load_case(file).runs["stiff"].signals["angle"].coordinate == "angle"
    file.write_text(text.replace('kind = "revolute"', 'kind = "cylindrical"'))
    with pytest.raises(InputError, match="joint hinge is cylindrical; expected angle or z"):
        load_case(file)


def test_check_names_an_unknown_driver(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(STARTERS / "arm", tmp_path, dirs_exist_ok=True)
    file = tmp_path / "case.toml"
    study = STUDY.replace("run =", 'driver = "slqsp"\nrun =')
    file.write_text(file.read_text().replace("[runs.base]", f"{study}[runs.base]"))
    assert main(["check", str(file)]) == 2
    assert "design.studies.s.driver = \"slqsp\": no such driver; did you mean 'slsqp'?" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("sweep", "of a case: `plymotion case.toml`, for a sweep with --sweep NAME"),
        ("packages", "of a case: `plymotion case.toml`, for a sweep with --sweep NAME"),
        ("report", "expected the folder of a case, such as build/CASE"),
    ],
)
def test_a_case_file_for_a_command_of_other_files(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: str, message: str
) -> None:
    monkeypatch.chdir(STARTERS / "arm")
    assert main([command, "case.toml"]) == 2
    assert message in capsys.readouterr().err


def test_a_sweep_file_for_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "sweep.json"
    file.write_text('{"case": "arm", "run": "base", "members": []}')
    assert main(["run", str(file)]) == 2
    assert "not a run file (a sweep, which `plymotion sweep` computes)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["run", "no.json"], "no.json: No such file or directory; expected a run file of"),
        (["solid", "no.step"], "no.step: no such file"),
        (["solid", "part.stl"], "part.stl: expected a STEP or IGES file, or a description"),
    ],
)
def test_files_of_commands(words, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("part.stl").write_text("solid part\nendsolid part\n")
    assert main(words) == 2
    assert message in capsys.readouterr().err


def test_keys_of_an_analysis_are_those_of_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The preprocessor has the description below a key of a body."""
    one = Entry("plate", tmp_path / "plate.toml")
    tell_failure(Made(one, tmp_path, "failed", "plate.toml: shell.supports.root.at = 'left': no"))
    assert capsys.readouterr().err == "error: plate.toml: supports.root.at = 'left': no\n"
