"""Files for other codes: what is written is read again to the same section."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.vabs_peer import relative
from samples.section_cases import section

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.vabs import spec_of_another_code
from plymotion.solver.report.section.codes import (
    convert,
    transform,
    turning_cells,
    write_beamdyn,
    write_becas,
    write_hawc2,
    write_vabs,
)


@pytest.fixture(scope="module")
def box() -> Any:
    return analyse(section("21", 0.5), estimate=False)


@pytest.mark.one_end
def test_vabs_round_trip(box: Any, tmp_path: Path) -> None:
    assert turning_cells(box) == 0
    file = write_vabs(box, tmp_path / "box.dat")
    again = analyse(spec_of_another_code(file, tmp_path), estimate=False)
    assert relative(again.K, box.K) < 1e-10
    assert relative(again.M, box.M) < 1e-12


def test_becas_round_trip(box: Any, tmp_path: Path) -> None:
    """Without the centre nodes the field is poorer, in rectangles by little."""
    folder = write_becas(box, tmp_path / "box")
    again = analyse(spec_of_another_code(folder, tmp_path), estimate=False)
    assert relative(again.K, box.K) < 2e-3
    assert relative(again.M, box.M) < 1e-12


def test_cells_that_turn_are_counted(tmp_path: Path) -> None:
    tube = analyse(section("14"), estimate=False)
    assert turning_cells(tube) == len(tube.mesh.cell_types)
    file = write_vabs(tube, tmp_path / "tube.dat")
    again = analyse(spec_of_another_code(file, tmp_path), estimate=False)
    assert 1e-4 < relative(again.K, tube.K) < 5e-2


def test_beamdyn(box: Any, tmp_path: Path) -> None:
    file = write_beamdyn(
        tmp_path / "blade.dat", [2.0, 5.0, 12.0], [box.K] * 3, [box.M] * 3, title="a blade"
    )
    lines = file.read_text().splitlines()
    assert lines[3].split()[0] == "3"
    assert lines[4].split()[0] == "0"
    assert lines[10].split()[:2] == ["0", "n_modes"]  # of OpenFAST 5
    numbers = [list(map(float, line.split())) for line in lines[13:] if line.strip()]
    assert [row[0] for row in numbers[::13]] == pytest.approx([0.0, 0.3, 1.0])
    np.testing.assert_allclose(numbers[1:7], convert(box.K, "beamdyn"), rtol=1e-12)
    np.testing.assert_allclose(numbers[7:13], convert(box.M, "beamdyn", "mass"), rtol=1e-12)
    assert numbers[3][2] == pytest.approx(box.K[0, 0])  # axial third


def test_hawc2(box: Any, tmp_path: Path) -> None:
    """About another point, which is neither elastic nor mass centre."""
    K, M = (transform(box.K, (0.003, -0.002)), transform(box.M, (0.003, -0.002), kind="mass"))
    file = write_hawc2(tmp_path / "st.dat", [0.0, 1.0], [K] * 2, [M] * 2, title="a blade")
    lines = file.read_text().splitlines()
    assert lines[3] == "$1 2"
    row = np.array(lines[4].split(), dtype=float)
    assert len(row) == 30
    assert row[1] == pytest.approx(box.M[0, 0])
    assert row[2:4] == pytest.approx(box.mass_centre - [0.003, -0.002], abs=1e-9)
    assert row[7:9] == pytest.approx(box.tension_centre - [0.003, -0.002], abs=1e-9)
    upper = np.zeros((6, 6))
    upper[np.triu_indices(6)] = row[9:]
    found = convert(upper + np.triu(upper, 1).T, "plymotion", source="becas")
    np.testing.assert_allclose(
        found, transform(box.K, box.tension_centre), atol=1e-9 * np.abs(found).max()
    )
    assert np.abs(np.linalg.inv(found)[0, 4:]).max() < 1e-12 * np.linalg.inv(found)[0, 0]


def test_stations_must_ascend(box: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="ascending"):
        write_beamdyn(tmp_path / "x", [0.0, 0.0], [box.K] * 2, [box.M] * 2, title="")
    with pytest.raises(InputError, match="2 sections"):
        write_hawc2(tmp_path / "x", [0.0, 1.0], [box.K], [box.M], title="")
