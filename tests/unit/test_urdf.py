"""`plymotion import ROBOT.urdf`: the case that it makes, and what it says of broken files."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.extras.robot.case import robot_case, start
from plymotion.solver.extras.robot.case_folder import fewer
from plymotion.solver.extras.robot.urdf import read_urdf
from plymotion.solver.results.surfaces import stl_triangles

ROBOTS = Path(__file__).parents[1] / "samples/robots"
WRIST = '<mimic joint="slide"/><dynamics damping="0.7"/>'
ARM = (ROBOTS / "arm.urdf").read_text()


def volume(triangles: np.ndarray) -> float:
    """Return the volume that a closed surface encloses, outward triangles."""
    return float(np.linalg.det(triangles).sum() / 6.0)


def test_a_robot_becomes_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Bodies with the axes of links, joints, torque behind the reduction, pictures."""
    out = tmp_path / "arm"
    assert main(["import", str(ROBOTS / "arm.urdf"), "--out", str(out)]) == 0
    assert "3 bodies, 3 joints" in capsys.readouterr().out
    case = pm.load(out)
    assert list(case.bodies) == ["upper_arm", "slider", "wrist"]
    assert case.bodies.wrist.mass == pytest.approx(0.55)
    assert set(case.bodies.wrist.interfaces) == {"wrist", "tool", "tip"}
    assert case.signals.shoulder_motor.divide_by == 100.0
    assert case.signals.shoulder_motor.keep_unit, "a torque [N m]"
    # the box keeps its volume and centre, the cylinder and sphere those of their polygons
    box = stl_triangles(out / "meshes/upper_arm.stl")
    assert volume(box) == pytest.approx(0.4 * 0.06 * 0.05, rel=1e-6)
    assert np.allclose(box.reshape(-1, 3).min(axis=0), [0.0, -0.03, -0.025], atol=1e-7)
    polygon = 0.5 * 24 * np.sin(2 * np.pi / 24) * 0.03**2
    assert volume(stl_triangles(out / "meshes/wrist.stl")) == pytest.approx(polygon * 0.1, rel=1e-5)
    ball = volume(stl_triangles(out / "meshes/slider.stl"))
    assert ball == pytest.approx(4.0 / 3.0 * np.pi * 0.05**3, rel=0.03)
    assert main(["import", str(ROBOTS / "arm.urdf"), "--out", str(out)]) == 2
    assert "already exists" in capsys.readouterr().err


def test_the_case_is_that_of_its_file(tmp_path: Path, repository: Path) -> None:
    """Bodies, places and axes of cases/robot-import are those that its arm.urdf gives."""
    out = tmp_path / "robot-import"
    folder = repository / "cases/robot-import"
    assert main(["import", str(folder / "arm.urdf"), "--out", str(out)]) == 0
    fresh, kept = pm.load(out).table, pm.load(folder).table
    for group in ("bodies", "ground"):
        assert fresh[group] == kept[group]
    for name, joint in fresh["joints"].items():
        assert {**joint, "drive": 0} == {**kept["joints"][name], "drive": 0}
    for name in fresh["bodies"]:
        mesh = f"meshes/{name}.stl"
        assert (out / mesh).read_bytes() == (folder / mesh).read_bytes()


def test_what_acts_in_free_joints(tmp_path: Path) -> None:
    """Actuators, friction, damping and stops of joints that no drive holds."""
    out = tmp_path / "arm"
    words = ["import", str(ROBOTS / "arm.urdf"), "--out", str(out), "--joints", "motor"]
    assert main(words) == 0
    forces = pm.load(out).forces
    assert forces.shoulder_friction == {
        "kind": "friction",
        "joint": "shoulder",
        "coulomb": 0.2,
        "viscous": 0.4,
        "rest_velocity": 0.01,
    }
    assert (forces.shoulder_stop.lower, forces.shoulder_stop.upper) == (-1.5, 2.0)
    assert forces.shoulder_stop.stiffness == pytest.approx(60.0 / 0.01)
    assert forces.slide_damping.derivative == 3.0
    assert forces.shoulder_motor.actuator == {"polynomial": [0.0]}


def test_what_limits_cannot_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A note for each; a joint that mimics another one has its friction, damping and stop."""
    text = ARM.replace('lower="-1.5" upper="2.0"', 'lower="-1.5" upper="-0.5"')
    text = text.replace('<joint name="shoulder"/>', '<joint name="shouldr"/>')
    geared = '<transmission name="t"><joint name="a&#10;b"/><mechanicalReduction>2'
    text = text.replace("</robot>", f"{geared}</mechanicalReduction></transmission></robot>")
    geared = "<transmission><joint name='slide'/><mechanicalReduction>"
    text = text.replace("</robot>", f"{geared}k</mechanicalReduction></transmission></robot>")
    text = text.replace("</robot>", f"{geared}0</mechanicalReduction></transmission></robot>")
    text = text.replace('lower="0" upper="0.3"', "")
    text = text.replace('<origin xyz="0 0.05 0.1" rpy="-0.6 0 0"/>', WRIST)
    (tmp_path / "arm.urdf").write_text(text)
    words = ["import", str(tmp_path / "arm.urdf"), "--joints", "free", "--no-meshes"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().err
    outside = "note: arm.urdf:42: <joint shoulder>: stands at 0, outside its limits -1.5 to -0.5: "
    assert outside in told
    assert "<joint slide>: no stops: its <limit> is 0 to 0" in told
    assert "transmission of shouldr: left out: no such joint; did you mean 'shoulder'?" in told
    assert "note: transmission of a\\nb: left out: no such joint" in told  # was a line of the case
    for value in "k0":
        wrong = f'slide: left out: <mechanicalReduction> "{value}"; expected a number other than 0'
        assert f"note: arm.urdf:69: transmission of {wrong}" in told
    assert pm.load(tmp_path / "out").forces.wrist_damping.derivative == 0.7


@pytest.mark.parametrize(
    ("limit", "note"),
    [
        ("", "no stops: it has no <limit>; expected one for type revolute, or type continuous"),
        ('<limit lower="0.5" upper="1" effort="9" velocity="1"/>', "stands at 0, outside its lim"),
        ('<limit lower="-1" upper="1" velocity="1"/>', "no stops: its <limit> has no effort"),
        ('<limit lower="-1" upper="1" effort="9"/>', "its <limit> has no velocity"),
    ],
)
def test_limits_are_told_where_drives_hold_the_joints(
    tmp_path: Path, limit: str, note: str
) -> None:
    """Of a joint that URDF demands limits of, and of one that they keep from where it stands.

    The wrist has no axis: the default is told.
    """
    (tmp_path / "arm.urdf").write_text(re.sub("<limit [^>]*60[^>]*/>", limit, ARM))
    notes = robot_case(read_urdf(tmp_path / "arm.urdf")).notes
    (axis,) = [each for each in notes if "wrist" in each]
    assert axis.startswith("arm.urdf:54: <joint wrist>: no <axis xyz>: ")
    (found,) = [each for each in notes if each != axis]
    assert found.startswith(f"arm.urdf:42: <joint shoulder>: {note}")


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_joints_that_no_drive_can_hold_are_told(tmp_path: Path, kind: str) -> None:
    """They move freely among joints that are held."""
    (tmp_path / "arm.urdf").write_text(ARM.replace('"prismatic"', f'"{kind}"'))
    robot = read_urdf(tmp_path / "arm.urdf")
    told = f"<joint slide>: no drive holds it: type {kind}, of more than one coordinate"
    assert told in " ".join(robot_case(robot).notes)
    assert told not in " ".join(robot_case(robot, joints="free").notes)


def test_mirrored_meshes_are_not_inside_out(tmp_path: Path) -> None:
    """The left side of a robot has the meshes of the right one, with a factor of -1."""
    out = tmp_path / "arm"
    assert main(["import", str(ROBOTS / "arm.urdf"), "--out", str(out)]) == 0
    mesh = f'<mesh filename="{out}/meshes/upper_arm.stl" scale="1 -1 1"/>'
    (tmp_path / "arm.urdf").write_text(ARM.replace('<box size="0.4 0.06 0.05"/>', mesh))
    assert main(["import", str(tmp_path / "arm.urdf"), "--out", str(tmp_path / "mirrored")]) == 0
    box = stl_triangles(tmp_path / "mirrored/meshes/upper_arm.stl")
    assert volume(box) == pytest.approx(0.4 * 0.06 * 0.05, rel=1e-6)


def test_stops_that_leave_no_room(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A finger that mimics another one in the opposite direction, as grippers of PR2 have it."""
    text = (ROBOTS / "gripper.urdf").read_text()
    assert 'multiplier="-1"' in text
    limit = '<limit lower="0" upper="0.05" effort="10" velocity="1"/>'
    text = re.sub(r"<limit [^>]*/>", limit, text)
    (tmp_path / "gripper.urdf").write_text(text)
    words = ["import", str(tmp_path / "gripper.urdf"), "--joints", "motor", "--no-meshes"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().err
    none = "<joint jaw_2>: no stops: its limits 0 to 0.05 leave no room to the joint that it mimics"
    assert none in told
    assert "jaw_1_stop" in pm.load(tmp_path / "out").forces
    assert "jaw_2_stop" not in pm.load(tmp_path / "out").forces


def test_limits_without_room_of_their_own_limit_no_other_joint(tmp_path: Path) -> None:
    """jaw_1 has no stops, because it has no limits: the joints that mimic it keep theirs."""
    text = (ROBOTS / "gripper.urdf").read_text()
    text = text.replace('lower="0" upper="0.1"', 'lower="0" upper="0"')
    (tmp_path / "gripper.urdf").write_text(text)
    words = ["import", str(tmp_path / "gripper.urdf"), "--joints", "motor", "--no-meshes"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    forces = pm.load(tmp_path / "out").forces
    assert "jaw_1_stop" not in forces
    assert "jaw_2_stop" in forces


def test_small_things_keep_their_inertia(tmp_path: Path) -> None:
    """Of 1 ug and 0.1 mm: what is rounding is a matter of the link, not of 1e-15 kg m2."""
    file = tmp_path / "grain.urdf"
    moments = 'ixx="4e-17" iyy="3e-17" izz="5e-17" ixy="1e-17" ixz="1e-33"'
    file.write_text(
        '<robot name="grain"><link name="base"/><link name="grain"><inertial><mass value="1e-9"/>'
        f'<inertia {moments}/></inertial></link><joint name="j" type="revolute">'
        '<parent link="base"/><child link="grain"/></joint></robot>'
    )
    made = robot_case(read_urdf(file))
    assert made.tables["bodies"]["grain"]["inertia"][0] == [4e-17, 1e-17, 0.0]
    # A radius of gyration of 0.04 of the way to the next joint, as some published robots have it.
    file.write_text(ARM.replace('xyz="0 0.05 0.1"', 'xyz="0 0.05 1.5"'))
    assert robot_case(read_urdf(file)).bodies["slider"].inertia.mass == 0.8


def test_joints_that_mimic_others(tmp_path: Path) -> None:
    """Displacements and rotations follow the jaw, from their offsets, in a run."""
    out = tmp_path / "gripper"
    words = ["import", str(ROBOTS / "gripper.urdf"), "--out", str(out), "--no-meshes"]
    assert main(words) == 0
    case = pm.load(out)
    assert list(case.couplings) == ["jaw_2_mimic", "thumb_mimic"]
    case.joints.jaw_1.drive = {"polynomial": [0.0, 0.1]}
    case.joints["drive"] = {"kind": "fixed", "between": ["ground.drive", "cart.drive"]}
    case.solver.t_end = 0.2
    found = pm.run(case, out=str(tmp_path / "build")).signals
    assert found["jaw_1_q"].final == pytest.approx(0.02, abs=1e-9)
    assert found["jaw_2_q"].final == pytest.approx(-0.02, abs=1e-7)
    assert found["thumb_q"].final == pytest.approx(0.16, abs=1e-6)


def test_a_long_chain_of_joints_that_mimic_each_other(tmp_path: Path) -> None:
    """q_k = 0.5 q_(k-1) + 0.1 from q_1 = 0: 0.2 far along it."""
    text = "<robot name='chain'><link name='l0'/>"
    for k in range(1, 1200):
        mimic = f"<mimic joint='j{k - 1}' multiplier='0.5' offset='0.1'/>" if k > 1 else ""
        text += f"<link name='l{k}'/><joint name='j{k}' type='continuous'><parent link='l{k - 1}'/>"
        text += f"<child link='l{k}'/><axis xyz='0 1 0'/>{mimic}</joint>"
    (tmp_path / "chain.urdf").write_text(text + "</robot>")
    robot = read_urdf(tmp_path / "chain.urdf")
    found = [start(robot, robot.joints[name]) for name in ("j1", "j3", "j1199")]
    assert found == pytest.approx([0.0, 0.15, 0.2], rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'type="prismatic"',
            'type="prismatik"',
            r':48: <joint slide>: type = "prismatik"; .* fixed; did you mean .prismatic.\?$',
        ),
        (
            'name="slide" type',
            'name="shoulder" type',
            r':48: <joint shoulder>: a second joint "shoulder"',
        ),
        (
            '<child link="wrist"/>',
            '<child link="wrst"/>',
            r'link "wrst": no such link; did you mean',
        ),
        (
            '<parent link="slider"/>',
            '<parent link="tip"/>',
            r"links without a parent: base, slider; expected one root|circle",
        ),
        (
            '<parent link="tool"/><child link="tip"/>',
            '<parent link="tool"/><child link="slider"/>',
            r'link "slider" is the child of joint "slide" too, which closes a loop',
        ),
        (
            '<link name="tip"/>',
            '<link name="tip"/><link name="bare"/><joint name="bare" type="continuous">'
            '<parent link="slider"/><child link="bare"/></joint>',
            r"<link bare>: moves without inertia; expected <inertial> with a mass",
        ),
        ('<mass value="0.8"/>', '<mass value="800"/>', r"<link slider>: 800 kg .* has .* kg/m3"),
        ('<mass value="2"/>', '<mass value="2000"/>', r":4: <link base>: 2000 kg .* m and kg m2"),
        ('<mass value="0.8"/>', '<mass value="0_8"/>', r'<mass value>: "0_8"; expected a number'),
        ('xyz="0 0.05 0.1"', 'xyz="0 50 0"', r"<link slider>: radius of gyration 0.061\d? m .*kg"),
        (
            '<mass value="0.8"/>',
            '<mass value="a lot"/>',
            r'<mass value>: "a lot"; expected a number',
        ),
        ('<mass value="0.8"/>', "", r"of link slider: no <mass>; expected one"),
        ('izz="0.0025"', 'izz="0.02"', r"<link slider>: no solid has principal moments"),
        (
            'ixx="0.002" iyy="0.003"',
            'ixx="0" iyy="0"',
            r"<link slider>: principal moments 0, .*expected all above 0, or --allow inertia",
        ),
        (
            '<mass value="0.8"/>',
            '<mass value="0.8"/><mass value="1.8"/>',
            r"link slider: a second <mass>; expected one",
        ),
        (
            '<axis xyz="1 0 1"',
            '<axes xyz="1 0 1"',
            r":50: joint slide: <axes>: no such element; did you mean 'axis'\?$",
        ),
        (
            'lower="-1.5"',
            'low="-1.5"',
            r"joint shoulder, <limit low>: no such attribute; did you mean 'lower'\?",
        ),
        ('xyz="1 0 1"', 'xyz="0 0 0"', r"joint slide, <axis xyz>: expected a vector of non-zero"),
        ('lower="-1.5"', 'lower="2.5"', r"joint shoulder, <limit>: lower = 2.5; expected at most"),
        ('name="tool"', 'name="wri/st"', r"no such link"),
        ('<link name="tip"/>', '<link name="tip"/><link name="x"/>', r"without a parent: base, x;"),
        ("</robot>", "", r"no XML: no element found"),
        (
            'upper="2.0"',
            'upper="180"',
            r":\d+: <joint shoulder>, <limit>: -1.5 to 180: expected rad",
        ),
        (
            'rpy="-0.6 0 0"',
            'rpy="-34 0 0"',
            r"<origin rpy>: -34 0 0; expected rad, found some like",
        ),
        ("<robot", "<sdf><robot", r"no XML"),
        (
            '<box size="0.4 0.06 0.05"/>',
            '<box size="0.4 -0.06 0.05"/>',
            r":16: link upper arm, <box>: -0.06; expected sizes of 0 or above \[m\]",
        ),
        (
            'xyz="1 0 1"',
            'xyz="1, 0 1"',
            r':50: joint slide, <axis xyz>: "1, 0 1"; expected 3 numbers with spaces between',
        ),
        (
            '<box size="0.4 0.06 0.05"/>',
            '<mesh filename="no.stl"/>',
            r"<mesh>: .*no.stl: no such file",
        ),
        (
            '<box size="0.4 0.06 0.05"/>',
            '<box size="400 60 50"/>',
            r":16: <link upper arm>, <box>: 400 m wide; expected m, found some like mm",
        ),
        (
            '<box size="0.4 0.06 0.05"/>',
            '<mesh filename="a.stl" scale="1 0 1"/>',
            r":16: link upper arm, <mesh scale>: 0; expected factors other than 0",
        ),
        (
            '<origin xyz="0 0.05 0.1"',
            '<origin xyz="0 1e300 0"',
            r"<origin xyz>: 0 1e\+300 0; expected m, within 1e\+06",
        ),
        (
            '<origin xyz="0 0.05 0.1" rpy="-0.6 0 0"/>',
            '<mimic joint="slide" offset="1e300"/>',
            r'<joint wrist>: <mimic joint="slide">: offset = 1e\+300; expected rad, found some',
        ),
        (
            '<box size="0.4 0.06 0.05"/>',
            '<mesh filename="broken.stl"/>',
            r":16: <link upper arm>, <mesh>: .*broken.stl: 0 triangles; expected an STL file",
        ),
        ('name="slide" type', 'name="${side}_slide" type', r":48: <joint .*>: a name of xacro; "),
        (
            '<box size="0.4 0.06 0.05"/>',
            '<mesh filename="package://arm_data/no.stl"/>',
            r'no folder "arm_data" with this file .* expected --package arm_data=PATH',
        ),
    ],
)
def test_broken_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    """File, line, element and what was expected; exit code 2; nothing is written."""
    assert old in ARM
    file = tmp_path / "broken.urdf"
    file.write_text(ARM.replace(old, new, 1))
    (tmp_path / "broken.stl").write_bytes(b"cut off" * 20)
    out = tmp_path / "case"
    assert main(["import", str(file), "--out", str(out)]) == 2
    text = capsys.readouterr().err
    assert text.startswith(f"error: {file}:"), text
    assert re.search(message, text), text
    assert not out.exists()


@pytest.mark.parametrize(("mass", "length"), [(1e3, 1.0), (1.0, 200.0)])
def test_all_in_other_units(tmp_path: Path, mass: float, length: float) -> None:
    """In g (and g m2), or in units of 5 mm: each ratio of a link is that of a robot."""

    def scaled(text: str, pattern: str, factor: float) -> str:
        def numbers(found: re.Match[str]) -> str:
            words = (f"{factor * float(word):.9g}" for word in found[2].split())
            return found[1] + " ".join(words)

        return re.sub(pattern, numbers, text)

    text = scaled(ARM, r'( i[xyz]{2}=")([^"]*)', mass * length**2)
    text = scaled(scaled(text, r'( xyz=")([^"]*)', length), r'(<mass value=")([^"]*)', mass)
    (tmp_path / "arm.urdf").write_text(text)
    robot = read_urdf(tmp_path / "arm.urdf")
    with pytest.raises(InputError, match=r"^\S+:\d+: <link .*kg/m3; expected kg, m and kg m2, or"):
        robot_case(robot)
    assert robot_case(robot, allow=["units"]).bodies


def test_names_that_clash(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two links that have one name in the case."""
    file = tmp_path / "clash.urdf"
    file.write_text(ARM.replace("upper arm", "a b").replace('"slider"', '"a.b"'))
    assert main(["import", str(file), "--out", str(tmp_path / "case")]) == 2
    text = capsys.readouterr().err
    assert re.search(r'<link a\.b>: the same name in the case, "a_b", as link "a b"', text), text
    words = ARM.replace("upper arm", "Über手").replace('"slider"', '"Uber足"')
    file.write_text(words, encoding="utf-8")
    made = robot_case(read_urdf(file))
    assert {"Uberu624b", "Uberu8db3"} <= set(made.tables["bodies"])
    with pytest.raises(InputError, match="joints = 'hodl': expected one of hold, motor, free"):
        robot_case(read_urdf(file), joints="hodl")  # type: ignore[arg-type]


def test_entities_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file cannot grow by its own entities."""
    file = tmp_path / "bomb.urdf"
    file.write_text('<!DOCTYPE r [<!ENTITY a "aaaa">]><robot name="&a;"><link name="l"/></robot>')
    assert main(["import", str(file), "--out", str(tmp_path / "case")]) == 2
    assert "expected a file without entities" in capsys.readouterr().err


def test_meshes_are_thinned() -> None:
    """A fine sphere keeps its size with at most the wanted triangles."""
    u, v = np.meshgrid(np.linspace(0, np.pi, 80), np.linspace(0, 2 * np.pi, 160))
    p = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
    one = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:]], axis=2).reshape(-1, 3, 3)
    two = np.stack([p[:-1, :-1], p[1:, 1:], p[:-1, 1:]], axis=2).reshape(-1, 3, 3)
    found = fewer(np.concatenate([one, two]), 800)
    assert 100 < len(found) <= 800
    assert abs(volume(found)) == pytest.approx(4.0 / 3.0 * np.pi, rel=0.1)


def test_meshes_that_need_a_library(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without trimesh an OBJ file has a message with the installation; a package is found above."""
    (tmp_path / "arm_data/urdf").mkdir(parents=True)
    (tmp_path / "arm_data/part.obj").write_text("v 0 0 0\n")
    file = tmp_path / "arm_data/urdf/arm.urdf"
    mesh = '<mesh filename="package://arm_data/part.obj"/>'
    file.write_text(ARM.replace('<box size="0.4 0.06 0.05"/>', mesh))
    monkeypatch.setitem(sys.modules, "trimesh", None)
    assert main(["import", str(file), "--out", str(tmp_path / "case")]) == 2
    text = capsys.readouterr().err
    assert re.search(r"part\.obj: .* needs trimesh; expected `pip install trimesh pycoll", text), (
        text
    )
    words = ["import", str(file), "--out", str(tmp_path / "case"), "--no-meshes"]
    assert main(words) == 0
