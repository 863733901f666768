"""What `plymotion blade --rotor` writes: strips, polars and operation from a windIO file."""

import csv

import numpy as np
import pytest
from samples.blade_samples import blade_table, write_blade
from samples.rotor_samples import ANGLES, polar

from plymotion.solver.errors import InputError
from plymotion.solver.extras.blade.aerodynamics import ANGLES as GRID
from plymotion.solver.extras.blade.aerodynamics import strips
from plymotion.solver.extras.blade.operation import WINDS, write_rotor
from plymotion.solver.extras.blade.stations import line_of
from plymotion.solver.extras.blade.tables import Tables
from plymotion.solver.extras.blade.windio import read_blade


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


def test_operation_is_at_rated_torque(tmp_path):
    files, *_ = write_rotor(read_blade(write_blade(tmp_path, turbine())), tmp_path)
    assert {f.name for f in files} == {"aero.csv", "polars.csv", "operation.csv"}
    with (tmp_path / "operation.csv").open() as file:
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
