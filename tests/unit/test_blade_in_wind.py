"""What `plymotion blade --rotor` writes: strips, polars and operation from a windIO file."""

import csv
import os
import re
import shutil
import subprocess
import tomllib
from copy import deepcopy
from types import SimpleNamespace

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, reduced
from samples.blade_samples import along, blade_table, write_blade
from samples.case_samples import computed_file
from samples.rotor_samples import ANGLES, polar
from scipy.integrate import solve_ivp

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.extras.blade.operation import ANGLES as GRID
from plymotion.solver.extras.blade.operation import WINDS, strips, write_rotor
from plymotion.solver.extras.blade.stations import line_of
from plymotion.solver.extras.blade.tables import Tables
from plymotion.solver.extras.blade.turbine import write_turbine
from plymotion.solver.extras.blade.windio import read_blade
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package.common.files import write_text
from plymotion.solver.package.common.plain_data import toml_text
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.generator_law import take_bent_blades

ACTUATOR = 4.0 * 35.0 * np.pi / 30.0  # [rad/s], without one in the file


def turbine():
    """The small blade with polars and numbers of control."""
    table = blade_table()
    c = polar()
    grid = ANGLES.tolist()
    sets = {k: {"grid": grid, "values": c[:, i].tolist()} for i, k in enumerate(("cl", "cd", "cm"))}
    for airfoil in table["airfoils"]:
        airfoil["polars"] = [{"configuration": "default", "re_sets": [{"re": 1e6, **sets}]}]
    table["assembly"] = {"hub_height": 40.0, "rated_power": 3e5, "number_of_blades": 3}
    table["control"] = {"rated_rotor_speed": 35.0, "optimal_tsr": 7.0}
    table["components"]["hub"] = {"diameter": 2.0, "cone_angle": 2.0}
    return table


def test_operation_is_at_rated_torque(rigid_case):
    folder, *_ = rigid_case
    assert {"aero.csv", "polars.csv", "rotor.toml"} < {f.name for f in folder.iterdir()}
    with (folder / "operation.csv").open() as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert [row["wind_m_s"] for row in rows] == list(WINDS)
    pitched = [row for row in rows if row["pitch_deg"] > 0.0]
    assert len(pitched) > 2
    for row in pitched:
        assert row["power_kw"] == pytest.approx(300.0, rel=1e-4)
        assert row["speed_rpm"] == pytest.approx(35.0, rel=1e-5)
    assert all(row["power_kw"] <= 300.1 for row in rows)


def test_strips_lie_on_the_blade(tmp_path):
    """Their widths add up to its length; the aerodynamic centre is a quarter of the chord behind
    the leading edge."""
    blade = read_blade(write_blade(tmp_path, turbine()))
    line = line_of(blade, np.linspace(0.0, 1.0, 2001).tolist())
    found = strips(blade, Tables(blade.file), turbine(), line, 12)
    assert sum(s.width for s in found) == pytest.approx(20.0)
    for s in found:
        assert s.offset == pytest.approx(blade.offset.at(s.r) - 0.25 * s.chord)
        assert s.twist_deg == pytest.approx(-blade.twist.at(s.r))
        np.testing.assert_allclose(s.polar[:, 0], np.interp(GRID, ANGLES, polar()[:, 0]), atol=0.03)


def whole():
    """The small blade with hub, nacelle and tower."""
    table = turbine()
    parts = table["components"]
    parts["hub"]["elastic_properties"] = {"mass": 3000.0, "inertia": [3e3, 2e3, 2e3, 0.0, 0.0, 0.0]}
    parts["drivetrain"] = {
        "outer_shape": {"uptilt": 0.0, "distance_tt_hub": 2.0, "overhang": 4.0},
        "elastic_properties": {"mass": 1.2e4, "inertia": [2e4, 3e4, 3e4, 0.0, 0.0, 0.0],
                               "location": [-1.0, 0.0, 1.5]},
    }  # fmt: skip
    parts["tower"] = {
        "reference_axis": {"z": {"grid": [0.0, 1.0], "values": [0.0, 38.0]}},
        "outer_shape": {"outer_diameter": along(3.0, 2.0)},
        "structure": {"layers": [{"material": "steel", "thickness": along(0.02, 0.02)}]},
    }
    table["materials"].append({"name": "steel", "orth": 0, "rho": 7800.0, "E": 2e11, "nu": 0.3})
    return table


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder, and what `write_turbine` needs before its folder."""
    folder = tmp_path_factory.mktemp("turbine")
    blade = read_blade(write_blade(folder, whole()))
    M = np.diag([100.0, 100.0, 100.0, 50.0, 10.0, 40.0])
    made = [SimpleNamespace(r=r, results=SimpleNamespace(M=M)) for r in (0.0, 0.5, 1.0)]
    _, strips, rotor, points = write_rotor(blade, folder)
    return folder, (blade, made, strips, rotor, points)


@pytest.fixture(scope="module")
def rigid_case(written):
    """Folder, the case of the turbine on rigid blades, its rotor and its operating points."""
    folder, (blade, made, strips, rotor, points) = written
    write_turbine(blade, made, strips, rotor, points, folder)
    return folder, *with_rigid_blades(folder, rotor, points)


def with_rigid_blades(folder, rotor, points):
    """The case of the turbine on rigid blades, its rotor, its operating points and its tower."""
    case = tomllib.loads((folder / "rotor.toml").read_text())
    points_of = rotor.mechanism.model_dump()["bodies"]["blade-1"]["interfaces"]
    tower = np.loadtxt(folder / "tower.csv", delimiter=",", skiprows=1)
    for name in rotor.blades:
        body = case["bodies"][name]
        case["bodies"][name] = {
            "kind": "rigid", "mass": 2000.0, "inertia": np.diag([1e3, 3e5, 3e5]).tolist(),
            **{key: body[key] for key in ("position", "rotation_deg", "angular_velocity")},
            "interfaces": {k: {"position": v["position"]} for k, v in points_of.items()},
        }  # fmt: skip
    for group, name in (("bodies", "tower"), ("joints", "foot"), ("signals", "flap"),
                        ("signals", "edge"), ("figures", "flap")):  # fmt: skip
        del case[group][name]
    case["ground"] = {"top": {"position": case["bodies"]["nacelle"]["position"]}}
    case["joints"]["yaw"]["between"][0] = "ground.top"
    return case, rotor, points, tower


def test_the_speed_follows_its_loop(rigid_case, tmp_path):
    """A step of the wind above the rated one: J dw = dQ/dpitch + dQ/dw + dQ/dwind, by hand.

    With filter, actuator and gains of the case; the wake is steady there, so that it is not exact.
    """
    folder, case, rotor, points, _ = rigid_case
    case = deepcopy(case)
    point = next(p for p in points if p.wind == 15.0)
    case["gravity"] = [0.0, 0.0, 0.0]
    case["parameters"] |= {"wind": 15.0, "gust": 0.3, "speed": point.speed, "fine_pitch": 0.0,
                           "pitch_deg": point.pitch}  # fmt: skip
    wind = "wind + gust * smooth_step(t, 1, 2)"
    case["rotor"]["wind"]["speed"]["expression"] = wind
    case["solver"] |= {"t_end": 16.0, "rtol": 1e-5}
    case["runs"] = {"all": {}}
    for key in ("figures", "sweeps", "coarse", "variants"):
        del case[key]
    result, summary = computed_file(folder / "case.toml", toml_text(case), run="all")
    found = {s.name: s.values for s in result.signals}
    assert summary["completed"]

    def slope(**change):
        at = {"wind": 15.0, "speed": point.speed, "pitch": point.pitch}
        up, down = (rotor.loads(*{**at, **{k: at[k] + s * d for k, d in change.items()}}.values())
                    for s in (1.0, -1.0))  # fmt: skip
        return (up[0] - down[0]) / 2.0

    by_pitch, by_speed, by_wind = (
        slope(pitch=np.degrees(1e-3)) / 1e-3, slope(speed=1e-3) / 1e-3, slope(wind=0.05) / 0.05
    )  # fmt: skip
    p = case["parameters"]
    J = np.interp(np.radians(point.pitch), case["tables"]["gain"]["x"], case["tables"]["gain"]["y"])
    J *= -by_pitch
    inertia = 3e3 + 3 * (3e5 + 2000.0)  # the hub, and the blades about the shaft
    w, f = p["w"], p["filter"]

    def rates(t, x):
        speed, measured, rate, integral, pitch = x
        gust = 0.3 * np.clip(t - 1.0, 0.0, 1.0) ** 2 * (3.0 - 2.0 * np.clip(t - 1.0, 0.0, 1.0))
        gained = -J / by_pitch * measured
        asked = integral + 2.0 * w * gained
        return [
            (by_pitch * pitch + by_speed * speed + by_wind * gust) / inertia,
            rate,
            f * (f * (speed - measured) - 1.4 * rate),
            w**2 * gained,
            ACTUATOR * (asked - pitch),
        ]

    # Before the wake follows, pitch changes the torque about twice as much: damping stays.
    A = np.column_stack([rates(0.0, unit) for unit in np.eye(5)])
    A[0, 4] *= 2.0
    roots = np.linalg.eigvals(A)
    assert (-roots.real / np.abs(roots)).min() > 0.5
    expected = solve_ivp(rates, (0.0, 16.0), np.zeros(5), t_eval=result.t, rtol=1e-8).y[0]
    change = found["speed"] - point.speed
    assert np.abs(change - expected).max() < 0.1 * np.abs(expected).max()


def test_the_law_of_the_generator_has_the_torque_of_the_blades_under_load(
    rigid_case, tmp_path, monkeypatch
):
    """Rigid blades: that of the operating points, between the least and the rated speed."""
    folder, case, rotor, points, _ = rigid_case
    case = deepcopy(case)
    case["parameters"]["best"] = 1.0
    write_text(folder / "again.toml", toml_text(case))
    monkeypatch.chdir(tmp_path)
    take_bent_blades(folder / "again.toml")
    p = tomllib.loads((folder / "again.toml").read_text())["parameters"]
    point = next(one for one in points if one.wind == p["wind"])
    assert 1.05 * p["slowest"] < point.speed < 0.94 * p["rated_speed"]
    assert p["best"] == pytest.approx(point.torque / point.speed**2, rel=1e-5)
    assert case["rotor"]["induction"] == rotor.mechanism.rotor.induction == "madsen"


BLADED = """
/* Pitch: 0.3 rad after the first second, as fast as the speed grows before; torque: 1e5 N m. */
void DISCON(float *swap, int *failed, const char *input, const char *output, char *message) {
  *failed = input[0] == '/' ? 0 : -1;
  if (swap[1] > 2.01f) *failed = -1;
  for (int k = 0; k < 9; k++) message[k] = "too late"[k];
  swap[44] = swap[1] > 0.99f ? 0.3f : swap[3];
  swap[46] = 1e5f * (swap[0] > 0.5f) + 10.0f * swap[19];
}
"""


def test_a_library_with_the_interface_of_bladed_controls_torque_and_pitch(written, tmp_path):
    """Its records: status, time, pitch and speed go in, torque and pitch come out."""
    compiler = shutil.which(os.environ.get("CC") or "cc")
    if compiler is None:
        pytest.skip("no C compiler")
    folder, (blade, made, strips, rotor, points) = written
    (tmp_path / "control.c").write_text(BLADED)
    library, given = tmp_path / "control.so", tmp_path / "DISCON.IN"
    given.write_text("")
    subprocess.run(
        [compiler, "-shared", "-fPIC", "-o", library, tmp_path / "control.c"], check=True
    )
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    files = write_turbine(blade, made, strips, rotor, points, tmp_path, (library, given))
    assert tmp_path / "bladed.py" in files
    case, *_ = with_rigid_blades(tmp_path, rotor, points)
    case["solver"] |= {"t_end": 2.0, "output_step": 0.05}
    case["signals"]["start"] = {"kind": "force", "of": "generator"}
    case["runs"] = {"all": {}}
    for key in ("figures", "sweeps", "coarse", "variants"):
        del case[key]
    (tmp_path / "case.toml").write_text(toml_text(case))
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    spec = read_run(tmp_path / "build/runs/all.json")
    with pytest.raises(InputError, match=r"bladed\.py\": runs Python code"):
        execute(spec, progress=False)
    result, _ = execute(spec, progress=False, allow_python=True)
    found = {s.name: s.values for s in result.signals}
    late = (result.t > 0.2) & (result.t < 1.9)
    torque = found["torque"] + found["start"]
    np.testing.assert_allclose(torque[late], -1e5 - 10.0 * found["speed"][late], rtol=1e-4)
    before, after = found["pitch"][result.t < 1.0], found["pitch"][result.t > 1.8]
    np.testing.assert_allclose(before, before[0], atol=0.02)
    np.testing.assert_allclose(after, 0.3, atol=0.02)
    spec = spec.changed({"solver.t_end": 3.0})
    with pytest.raises(InputError, match=r"control\.so: too late"):
        execute(spec, progress=False, allow_python=True)
    program = (tmp_path / "bladed.py").read_text()
    (tmp_path / "bladed.py").write_text(program.replace("control.so", "absent.so"))
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "build")
    spec = read_run(tmp_path / "build/runs/all.json")
    with pytest.raises(InputError, match=r"code\.file = .*absent\.so: cannot open"):
        execute(spec, progress=False, allow_python=True)


def test_the_tower_is_a_tube(rigid_case):
    """Area and second moment of a tube of 3 m with a wall of 20 mm; its mass."""
    *_, tower = rigid_case
    outer, inner = 3.0, 2.96
    area, second = np.pi / 4.0 * (outer**2 - inner**2), np.pi / 64.0 * (outer**4 - inner**4)
    K = tower[0, 4:25]
    np.testing.assert_allclose(K[[0, 18, 20]], [2e11 * area, *[2e11 * second] * 2], rtol=1e-9)
    assert tower[0, 25] == pytest.approx(7800.0 * area)


def test_blades_twist_under_moments_along_them(rigid_case):
    """Uniform blade, a moment at each strip that grows outwards: strain energy over the exact one.

    Vibrations alone miss much of it.
    """
    body = tomllib.loads((rigid_case[0] / "rotor.toml").read_text())["bodies"]["blade-1"]
    K = np.diag([1e9, 1e8, 1e8, 2e7, 3e7, 1e8])
    shares = []
    for modes in (body["modes"], body["modes"][:1]):
        beam = reduced(CLAMPED, modes, elements=24, length=20.0, K=K, interfaces=body["interfaces"])
        strips = [beam.interface(name) for name in body["interfaces"] if name[0] == "a"]
        x = np.array([s.position_B[0] for s in strips])
        load = sum(p * (s.psi_B[0] - beam.interface("root").psi_B[0])
                   for p, s in zip(x - 8.0, strips, strict=True))  # fmt: skip
        exact = (x - 8.0) @ np.minimum.outer(x, x) @ (x - 8.0) / K[3, 3]
        shares.append(load @ np.linalg.solve(beam.package.stiffness, load) / exact)
    assert shares[0] == pytest.approx(1.0, abs=0.02)
    assert shares[1] < 0.9, shares


def test_messages_of_what_is_missing(tmp_path):
    table = turbine()
    del table["airfoils"][1]["polars"]
    blade = read_blade(write_blade(tmp_path, table))
    with pytest.raises(InputError, match=r"small\.yaml: airfoils\.thin\.polars"):
        write_rotor(blade, tmp_path)
    assert not list(tmp_path.glob("*.csv"))
    table = turbine()
    table["assembly"]["rotor_orientation"] = "downwind"
    blade = read_blade(write_blade(tmp_path, table))
    with pytest.raises(InputError, match=r"rotor_orientation: 'downwind'; expected 'upwind'"):
        write_rotor(blade, tmp_path)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("hub", r"components\.hub\.elastic_properties: missing"),
        ("drivetrain", r"components\.drivetrain\.elastic_properties\.mass"),
        ("airfoils", r"airfoils\.thin\.polars"),
    ],
)
def test_what_a_rotor_lacks_is_said_before_the_stations(tmp_path, capsys, key, words):
    table = whole()
    if key == "airfoils":
        del table["airfoils"][1]["polars"]
    elif key == "hub":
        del table["components"]["hub"]["elastic_properties"]
    else:
        del table["components"]["drivetrain"]["elastic_properties"]["mass"]
    file, out = write_blade(tmp_path, table), tmp_path / "out"
    assert main(["blade", str(file), "--rotor", "--check", "-o", str(out)]) == 2
    assert re.search(words, capsys.readouterr().err)
    assert not out.exists()
