"""`plymotion blade --spin`: frequencies over speed, their estimated errors, the case of a blade."""

import csv
import shutil
import tomllib

import numpy as np
import pytest
from samples.blade_samples import along, blade_table, write_blade

from plymotion.solver.__main__ import main
from plymotion.solver.extras.blade.stations import analysed, frequencies_at_rest
from plymotion.solver.extras.blade.windio import Hub, read_blade
from plymotion.solver.workers.launch import kept_preprocessors

pytestmark = pytest.mark.usefixtures("one_fenicsx")
HUB = {"diameter": 3.0, "cone_angle": 5.0}


def rows(file):
    with file.open(newline="") as stream:
        return [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(stream)]


def blade_file(folder, **assembly):
    table = blade_table()
    table["components"]["hub"] = HUB
    table["components"]["blade"]["reference_axis"]["x"] = along(0.0, -0.1, -0.4)
    if assembly:
        table["assembly"] = assembly
    return write_blade(folder, table)


@pytest.fixture(scope="module")
def spun(fenicsx, tmp_path_factory):
    """Files of a blade with five stations over two speeds, and of the same blade with seventeen.

    And of nine of these: frequencies at rest and their errors, as the command has them.
    """
    folder = tmp_path_factory.mktemp("spun")
    file = blade_file(folder)
    few, many = folder / "few", folder / "many"
    words = ["blade", str(file), "--quiet"]
    places = {f"r{round(1e4 * r):05d}": float(r) for r in np.linspace(0.0, 1.0, 17)}
    with pytest.MonkeyPatch.context() as patch, kept_preprocessors():
        patch.chdir(folder)
        assert main([*words, "--stations", "5", "-o", str(few), "--spin", "0:6:3"]) == 0
        shutil.copytree(few, many)  # has five of the seventeen stations
        assert main([*words, "--stations", "17", "-o", str(many), "--no-estimate"]) == 0
        nine = analysed(many / "sections", places, dict.fromkeys([*places][::2]))
        return few, many, frequencies_at_rest(read_blade(file), nine)


def test_one_command_gives_frequencies_over_speed(spun):
    few, *_ = spun
    at_rest = [row["frequency_hz"] for row in rows(few / "frequencies.csv")]
    assert len(at_rest) == 6
    assert np.all(np.diff(at_rest) > 0.0)
    table = rows(few / "campbell.csv")
    assert [row["speed [rad/s]"] for row in table] == [0.0, 3.0, 6.0]
    found = np.array(
        [[w for key, w in row.items() if key.endswith("1 [rad/s]")] for row in table]
    ) / (2.0 * np.pi)
    # The body has the modes of the clamped blade: at rest its frequencies, but for the elements.
    np.testing.assert_allclose(found[0, :2], at_rest[:2], rtol=1e-6)
    # Southwell: f^2 = f0^2 + S (speed / 2 pi)^2, S = 1.3 for a uniform blade, more with taper
    S = (found[1:, 0] ** 2 - found[0, 0] ** 2) / (np.array([3.0, 6.0]) / (2.0 * np.pi)) ** 2
    assert S[0] == pytest.approx(S[1], rel=0.02)
    assert 1.2 < S[0] < 2.0
    assert (few / "campbell.png").is_file()


def test_errors_of_frequencies_are_estimated_by_cause(spun):
    """The errors of five and of nine stations, by the frequencies of seventeen."""
    few, many, (nine, errors) = spun
    estimated = rows(few / "frequencies.csv")
    denser = [row["frequency_hz"] for row in rows(many / "frequencies.csv")]
    assert errors.keys() == {"stations", "elements"}  # the sections have no estimate
    for k in range(2):
        error = abs(nine[k] / denser[k] - 1.0)
        assert 0.5 * error < errors["stations"][k] < 8.0 * error
        assert (
            0.5 * abs(estimated[k]["frequency_hz"] / denser[k] - 1.0)
            < (estimated[k]["error_stations"])
        )
        assert 0.0 < estimated[k]["error_sections"] < 0.01
        assert 0.0 < estimated[k]["error_elements"] < 1e-3


def test_the_blade_stands_on_the_hub_of_the_file(spun):
    few, *_ = spun
    case = tomllib.loads((few / "case.toml").read_text(encoding="utf-8"))
    blade = case["bodies"]["blade"]
    angle = np.radians(5.0)
    root = 1.5 * np.array([np.cos(angle), 0.0, -np.sin(angle)])  # to the pressure side
    np.testing.assert_allclose(blade["position"], root, rtol=1e-12)
    np.testing.assert_allclose(case["bodies"]["hub"]["interfaces"]["rim"]["position"], root)
    assert blade["rotation_deg"] == [0.0, 5.0, 0.0]


@pytest.mark.parametrize(("orientation", "cone"), [("Upwind", 5.0), ("Downwind", -5.0)])
def test_the_cone_of_a_downwind_rotor_is_to_the_suction_side(tmp_path, orientation, cone):
    file = blade_file(tmp_path, rotor_orientation=orientation)
    assert read_blade(file).hub == Hub(1.5, cone)


def test_a_file_without_hub_has_the_root_on_the_axis(tmp_path):
    assert read_blade(write_blade(tmp_path)).hub == Hub(0.0, 0.0)


@pytest.mark.parametrize("speeds", ["2:1:0.1", "0:1:x", "0:1:0"])
def test_wrong_speeds_are_refused_before_anything_is_computed(tmp_path, capsys, speeds):
    file = write_blade(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["blade", str(file), "--spin", speeds, "-o", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert f"--spin: {speeds}: " in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_one_station_has_no_frequencies(fenicsx, tmp_path, capsys):
    file = write_blade(tmp_path)
    words = ["--at", "0.5", "-o", str(tmp_path / "out"), "--spin", "0", "--no-estimate", "--quiet"]
    assert main(["blade", str(file), *words]) == 2
    assert "--spin 0: expected two complete stations or more" in capsys.readouterr().err
    assert not (tmp_path / "out" / "case.toml").exists()
