"""Where a beam is enough for a box and where it is not, against a shell model of the same box."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from shell_specs import METAL, SCRIPTS

from plymotion.preprocess.shell.analysis import analyse
from plymotion.solver.fidelity.section_walls import Walls, local_frequency

Record = Callable[[str, Any], None]
LENGTH, SIDE = 1.0, 0.1


def shell_frequencies(thickness: float, count: int) -> np.ndarray:
    """Frequencies [Hz] of a square box clamped at one end, with a rigid tip."""
    size = {"length": LENGTH, "width": SIDE + thickness, "height": SIDE + thickness}
    size |= {"wall": thickness, "n_length": 40, "n_width": 6, "n_height": 6}
    regions = ("top", "right", "bottom", "left")
    found = analyse(
        {
            "name": "box",
            "mesh": {"file": str(SCRIPTS / "box-beam.py"), "parameters": size},
            "materials": {"metal": METAL},
            "regions": {name: {"material": "metal", "thickness": thickness} for name in regions},
            "supports": {"root": {"at": "root", "fixed": "all"}},
            "links": {"tip": {"at": "tip", "kind": "rigid"}},  # as an interface of a body has it
            "frequencies": {"count": count},
        }
    )
    assert found.modes is not None
    return np.asarray(found.modes.frequencies) / (2.0 * np.pi)


def beam_frequencies() -> np.ndarray:
    """First two bending frequencies [Hz] of the beam, whatever its thickness; without shear."""
    radius = SIDE / np.sqrt(6.0)
    speed = np.sqrt(METAL["E"] / METAL["rho"])
    return np.array([1.8751, 4.6941]) ** 2 * speed * radius / (2.0 * np.pi * LENGTH**2)


def local(thickness: float) -> float:
    """The indicator's frequency of a wall [Hz]."""
    K, M = np.zeros((6, 6)), np.zeros((6, 6))
    area = 4.0 * SIDE * thickness
    K[0, 0], M[0, 0] = METAL["E"] * area, METAL["rho"] * area
    return local_frequency(Walls(SIDE, thickness), K, M) / (2.0 * np.pi)


def test_a_box_with_thick_walls_is_a_beam(record: Record) -> None:
    """The walls' own frequency is above the second of the beam: the shell has the beam's modes."""
    thickness = 6e-3
    found, beam = shell_frequencies(thickness, 4), beam_frequencies()
    assert local(thickness) > beam[1]
    assert found[:2] == pytest.approx([beam[0]] * 2, rel=0.05)
    assert found[2] > 0.7 * beam[1]  # second bending, lower by shear
    record("beam-or-shell/thick", found)


def test_a_box_with_thin_walls_is_no_beam(record: Record) -> None:
    """Its walls vibrate far below the second frequency of the beam, where the indicator says."""
    thickness = 1e-3
    found, beam = shell_frequencies(thickness, 8), beam_frequencies()
    assert found[:2] == pytest.approx([beam[0]] * 2, rel=0.1)
    assert local(thickness) < 0.5 * beam[1]
    of_walls = found[2:]
    assert np.all(of_walls < 0.6 * beam[1])
    assert of_walls[0] == pytest.approx(local(thickness), rel=0.25)
    record("beam-or-shell/thin", found)
