"""Materials by name: published values in cases, sections, shells and solids."""

import json
import tomllib

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.common.input_table import Name, Table, entry, validated
from plymotion.solver.inputs.common.materials import Material, check_materials
from plymotion.solver.inputs.common.published_materials import LIBRARY


class Materials(Table):
    """The table of every file that has materials."""

    materials: dict[Name, Material] = entry("elastic materials")


def read(table):
    return validated(Materials, {"materials": {"m": table}}, "file").materials["m"]


def test_published_values_of_the_source():
    """Soden, Hinton and Kaddour (1998), Table 2: AS4/3501-6; G23 = E2 / 2(1 + nu23)."""
    ply = read({"library": "as4-3501-6", "rho": 1580.0})
    assert (ply.E1, ply.E2, ply.G12, ply.nu12) == (126e9, 11e9, 6.6e9, 0.28)
    assert pytest.approx(11e9 / 2.8, rel=2e-4) == ply.G23
    assert (ply.strength.Xt, ply.strength.Yc, ply.strength.S12) == (1950e6, 200e6, 79e6)
    assert pytest.approx(10.3e6 * 6894.757, rel=1e-3) == read("al-7075-t6").E


# MIL-HDBK-5J (31 January 2003, approved for public release): E [1e6 psi], mu, omega [lb/in3]. Read
# in transcriptions of its tables, which agree.
HANDBOOK = [
    ("al-2024-t3", "3.2.3.0(b1)", 10.5, 0.33, 0.100),
    ("al-6061-t6", "3.6.2.0(b1)", 9.9, 0.33, 0.098),
    ("al-7075-t6", "3.7.6.0(b1)", 10.3, 0.33, 0.101),
    ("steel-4130", "2.3.1", 29.0, 0.32, 0.283),
    ("ti-6al-4v", "5.4.1.0(b)", 16.0, 0.31, 0.160),
]


@pytest.mark.parametrize(("name", "table", "E", "nu", "rho"), HANDBOOK)
def test_metals_of_the_handbook(name, table, E, nu, rho):
    metal = read(name)
    assert table in LIBRARY[name].source
    assert pytest.approx(E * 6.894757e9, rel=1e-3) == metal.E
    assert metal.nu == nu
    assert metal.rho == pytest.approx(rho * 27679.9, abs=0.5)


@pytest.mark.parametrize("name", LIBRARY)
def test_every_material_is_possible(name):
    material = read({"library": name, "rho": 1600.0})
    assert not check_materials({name: material})
    assert LIBRARY[name].source


def test_own_values_replace_those_of_the_library():
    assert read({"library": "as4-3501-6", "rho": 1600.0, "E1": 130e9}).E1 == 130e9


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("as4-3501-7", "did you mean 'as4-3501-6'?"),
        ("as4-3501-6", "materials.m.rho: missing; expected a value: density"),
        ({"library": "al-6061-t6", "E1": 70e9}, "materials.m.E1: unknown key"),
    ],
)
def test_mistakes_are_named(table, message):
    with pytest.raises(InputError) as error:
        read(table)
    assert message in str(error.value)


def test_the_command_prints_what_a_file_can_have(capsys):
    assert main(["materials"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed and LIBRARY[name].source in listed for name in LIBRARY)
    assert main(["materials", "e-glass-ly556"]) == 0
    table = tomllib.loads(capsys.readouterr().out)["materials"]["e-glass-ly556"]
    assert table == json.loads(json.dumps(LIBRARY["e-glass-ly556"].table))
    assert main(["materials", "e-glass-ly557"]) == 2
    assert "did you mean 'e-glass-ly556'?" in capsys.readouterr().err
