"""Observed order and absolute error of the plates and membranes, on regular and distorted meshes.

Exact values: Navier's series of tests/reference/shells for plates, shear waves for membranes.
Distorted: inner nodes shifted at random by up to a quarter of a cell.
"""

import tomllib

import numpy as np
import pytest
from samples.shell_benchmarks import FILE, expected, numbers
from samples.shell_squares import in_plane

# The elements with both DOLFINx: test_shell_benchmarks.py.
pytestmark = pytest.mark.one_end

DISTORTED = {"distortion": 0.25}
MESHES = {"regular": {}, "distorted": DISTORTED}


def errors(name: str, plate: str, mesh: dict[str, float], cells: tuple[int, ...]) -> np.ndarray:
    """Relative error of the deflection on a row of meshes."""
    found = [numbers(name, n, elements={"plate": plate}, mesh=mesh)[0] for n in cells]
    return np.array(found) / expected(name) - 1.0


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(
    ("name", "plate", "largest"),
    [
        # measured at 32 x 32, regular and distorted
        ("mindlin_ss_uniform_Lh10", "dkmt", 1.2e-3),  # 0.9e-3, 1.1e-3
        ("mindlin_ss_uniform_Lh10", "mitc3", 3.6e-3),  # 2.9e-3, 3.3e-3
        ("mindlin_ss_uniform_Lh100", "dkmt", 1.2e-3),
        ("mindlin_ss_uniform_Lh100", "mitc3", 5.5e-3),  # 3.9e-3, 4.5e-3
        ("fsdt_sin_0_90_0_ah10", "dkmt", 1.8e-3),  # 1.3e-3, 1.6e-3
        ("fsdt_sin_0_90_ah20", "dkmt", 4.0e-3),  # 2.8e-3, 3.4e-3
    ],
)
def test_plates_of_second_order(name: str, plate: str, largest: float, mesh: str) -> None:
    error = np.abs(errors(name, plate, MESHES[mesh], (8, 16, 32)))
    assert error[-1] < largest
    assert np.log2(error[0] / error[-1]) / 2.0 > 1.8


def test_dkt_is_of_second_order_where_shear_does_not_count() -> None:
    error = np.abs(errors("mindlin_ss_uniform_Lh10000", "dkt", DISTORTED, (8, 16, 32)))
    assert error[-1] < 1.5e-3
    assert np.log2(error[0] / error[-1]) / 2.0 > 1.8


TABLE = tomllib.loads((FILE.parent / "plates_by_element.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("plate", "cells"), [("dst", 8), ("dst", 16), ("dkmt", 32), ("dkt", 32), ("mitc3", 8)]
)
def test_plates_have_the_digits_of_another_program(plate: str, cells: int) -> None:
    found = [
        numbers(f"mindlin_ss_uniform_Lh{ratio}", cells, elements={"plate": plate})[0]
        for ratio in TABLE["slenderness"]
    ]
    assert found == pytest.approx(TABLE[plate][str(cells)], abs=TABLE["tolerance"])


def test_dst_on_regular_isotropic_meshes() -> None:
    error = np.abs(errors("mindlin_ss_uniform_Lh10", "dst", {}, (8, 16, 32)))
    assert error[-1] < 1.2e-3


def test_dst_does_not_converge() -> None:
    """Its rotations differ from both sides of an edge once h is not small against the element."""
    isotropic = errors("mindlin_ss_uniform_Lh10", "dst", DISTORTED, (16, 32, 64))
    assert np.all(np.diff(isotropic) > 0.0)
    assert 5e-3 < isotropic[-1] < 9e-3  # +0.7 %
    laminate = errors("fsdt_sin_0_90_0_ah10", "dst", {}, (16, 32, 64))
    assert laminate == pytest.approx(-0.026, abs=2e-3)  # -2.7 %, on any mesh


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(
    ("membrane", "largest"), [("opt", 3.1e-2), ("allman", 2.5e-2), ("cst", 2.5e-2)]
)
def test_membranes_of_second_order(membrane: str, largest: float, mesh: str) -> None:
    """Shear waves in the plane of a square: 1, 1, sqrt(2) times half the speed over the side."""
    found = []
    for n in (4, 8, 16):
        model, read = in_plane(n)
        found.append(read(model.solved(elements={"membrane": membrane}, mesh=MESHES[mesh])))
    error = np.abs(np.array(found) / [1.0, 1.0, np.sqrt(2.0)] - 1.0)
    assert np.all(error[1] < largest)
    assert np.all(np.log2(error[0] / error[2]) / 2.0 > 1.6)


def test_cst_locks_in_the_plane() -> None:
    """MacNeal and Harder's straight beam, one cell across: opt exact to 4 %, cst 30 times stiff."""
    found = {
        membrane: numbers("straight_in", (6, 1), elements={"membrane": membrane})[0]
        / expected("straight_in")[0]
        for membrane in ("opt", "allman", "cst")
    }
    assert found["opt"] == pytest.approx(1.0, abs=0.04)
    assert 0.1 < found["allman"] < 0.3
    assert found["cst"] == pytest.approx(0.032, abs=0.005)  # 0.032 by an independent prototype
