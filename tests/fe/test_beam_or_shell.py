"""Where a beam is enough for a box or strip and where it is not, against shells of the same."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.section_specs import library_spec, rectangle_spec
from samples.shell_specs import METAL, SCRIPTS
from scipy.linalg import eigh

from plymotion.preprocess.section import section_analysis as section
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.solver.studies.fidelity.indicators.beam_theory import (
    Walls,
    local_frequency,
    ovalisation,
    short_waves,
    walls_carried,
)

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


def free_beam(EI: float, kGA: float, m: float, rho_I: float) -> np.ndarray:
    """First frequencies [Hz] of a free beam with shear, by 200 linear elements."""
    n = 200
    h = LENGTH / n
    K, M = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
    shear = np.array([-1.0 / h, -0.5, 1.0 / h, -0.5])
    curvature = np.array([0.0, -1.0 / h, 0.0, 1.0 / h])
    k = h * (kGA * np.outer(shear, shear) + EI * np.outer(curvature, curvature))
    mass = np.kron(h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]]), np.diag([m, rho_I]))
    for i in range(n):
        those = slice(2 * i, 2 * i + 4)
        K[those, those] += k
        M[those, those] += mass
    values = eigh(K, M, eigvals_only=True, subset_by_index=[2, 5])
    return np.asarray(np.sqrt(values) / (2.0 * np.pi))


@pytest.mark.parametrize("thickness", [6e-3, 10e-3])
def test_walls_lower_the_frequencies_of_a_box(thickness: float, record: Record) -> None:
    """A free box: first and second bending against the beam with shear."""
    outer = SIDE + thickness
    size = {"length": LENGTH, "width": outer, "height": outer, "wall": thickness}
    cells = {"n_length": 40, "n_width": 4, "n_height": 4}
    regions = ("top", "right", "bottom", "left")
    modes = analyse(
        {
            "name": "box",
            "mesh": {
                "file": str(SCRIPTS / "box-beam.py"),
                "element": "quadrilateral",
                "parameters": size | cells,
            },
            "materials": {"metal": METAL},
            "regions": {name: {"material": "metal", "thickness": thickness} for name in regions},
            "frequencies": {"count": 12, "free": True},
        }
    ).modes
    assert modes is not None
    found = np.asarray(modes.frequencies) / (2.0 * np.pi)
    sizes = {"width": outer, "height": outer, "wall": thickness}
    of = section.analyse(library_spec("box", sizes, METAL), estimate=False)
    beam = free_beam(of.K[4, 4], of.K[2, 2], of.M[0, 0], of.M[4, 4])
    pairs = found[:-1][np.abs(np.diff(found)) < 1e-4 * found[1:]]  # bending about two axes
    pairs = pairs[pairs > 0.5 * beam[0]]
    below = [float(f) for f in beam[:2] if f < 0.8 * local(thickness)]
    near = [float(pairs[np.argmin(np.abs(pairs - f))]) for f in below]
    lower = [1.0 - found / f for found, f in zip(near, below, strict=True)]
    ratios = [walls_carried(f / local(thickness)) / x for f, x in zip(below, lower, strict=True)]
    record(f"beam-or-shell/walls-{thickness}", np.array(near))  # ratios are small differences
    assert min(ratios) > 0.5
    assert max(ratios) < 4.0


def test_short_waves_of_a_strip(record: Record) -> None:
    """Frequencies of a strip with hinged ends, where all modes are sine waves along it.

    What waves change, of a beam without shear: bending against the exact value of the beam, torsion
    against the first wave, because GJ of shell and section differ by 1 % themselves.
    """
    length, width, thickness = 1.0, 0.1, 4e-3
    size = {"length": length, "width": width, "n_length": 80, "n_width": 8}
    hinged = {name: {"at": name, "fixed": ["uz"]} for name in ("left", "right")}
    hinged["plane"] = {"at": "left", "fixed": ["ux", "uy", "rz"]}
    modes = analyse(
        {
            "name": "strip",
            "mesh": {
                "file": str(SCRIPTS / "plate.py"),
                "element": "quadrilateral",
                "parameters": size,
            },
            "materials": {"metal": METAL},
            "regions": {"all": {"material": "metal", "thickness": thickness}},
            "supports": hinged,
            "frequencies": {"count": 12},
        }
    ).modes
    assert modes is not None
    found = np.asarray(modes.frequencies) / (2.0 * np.pi)
    of = section.analyse(rectangle_spec(width, thickness, METAL), estimate=False)
    held = np.diag(of.end_compliance) * np.diag(of.K)
    walls = Walls(width, thickness, hinged=False)

    def indicated(row: int, j: int) -> float:
        return short_waves(walls, float(held[row]), length / j)

    def nearest(frequency: float) -> float:
        return float(found[np.argmin(np.abs(found - frequency))])

    I = width * thickness**3 / 12.0  # noqa: E741
    speed = np.sqrt(METAL["E"] * I / (METAL["rho"] * width * thickness)) / (2.0 * np.pi)
    torsion = np.sqrt(of.K[3, 3] / (METAL["rho"] * width * (width**2 + thickness**2) * thickness))
    first = nearest(torsion * np.sqrt(12.0) / (2.0 * length))
    ratios, near = [], []
    for j in (2, 3, 4, 5):
        beam = speed * (j * np.pi / length) ** 2
        near.append(nearest(beam * (1.0 + indicated(4, j))))
        ratios.append(indicated(4, j) / (near[-1] / beam - 1.0))
    for j in (2, 3):
        more = indicated(3, j) - indicated(3, 1)
        near.append(nearest(j * first * (1.0 + more)))
        ratios.append(more / (near[-1] / (j * first) - 1.0))
    record("beam-or-shell/waves", np.array(near))  # ratios are small differences
    assert min(ratios) > 0.8
    assert max(ratios) < 1.4


def test_ovalisation_of_a_box(record: Record) -> None:
    """The stresses of bending as a pressure on the flanges of a shell, in a second step.

    A flange carries E kappa b / 2 and turns with kappa: the pressure is t times both. Flanges that
    come nearer by w on average take 3 w / b from the bending stiffness.
    """
    thickness, kappa = 1e-3, 0.01
    pressure = METAL["E"] * kappa**2 * SIDE * thickness / 2.0
    size = {"length": SIDE, "width": SIDE + thickness, "height": SIDE + thickness}
    size |= {"wall": thickness, "n_length": 4, "n_width": 16, "n_height": 16}
    mesh = {"file": str(SCRIPTS / "box-beam.py"), "element": "quadrilateral", "parameters": size}
    corners = {"top-right": ["ux", "uy"], "right-bottom": ["uy"], "bottom-left": ["uz"]}
    shell = analyse(
        {
            "name": "ring",
            "mesh": mesh,
            "materials": {"metal": {**METAL, "nu": 0.0}},  # without contraction along the corners
            "regions": {
                name: {"material": "metal", "thickness": thickness}
                for name in ("top", "right", "bottom", "left")
            },
            "supports": {name: {"at": name, "fixed": fixed} for name, fixed in corners.items()},
            "loads": {
                "bending": {name: {"at": name, "pressure": -pressure} for name in ("top", "bottom")}
            },
        }
    )
    assert shell.cases is not None
    z, uz = shell.mesh.nodes_G[:, 2], shell.cases.displacements_G[0, :, 2]
    top, bottom = (float(uz[np.abs(z - side * SIDE / 2.0) < 1e-9].mean()) for side in (1, -1))
    loss = 3.0 * 0.5 * (bottom - top) / SIDE
    indicated = ovalisation(Walls(SIDE, thickness), kappa)
    record("beam-or-shell/ovalisation", np.array([loss, indicated]))
    assert indicated == pytest.approx(loss, rel=0.25)
