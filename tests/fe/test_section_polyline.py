"""Walls along a polyline: the same sections as those of the library with the same walls."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand, walls

CFRP = {
    "kind": "orthotropic",
    **{"E1": 142e9, "E2": 9.8e9, "E3": 9.8e9, "G12": 6.0e9, "G13": 6.0e9, "G23": 4.8e9},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1600.0},
}
ANGLES = {"top": [15, 30], "right": [-45, 0], "bottom": [60, 10], "left": [90, -20]}
WIDTH, HEIGHT, WALL = 0.03, 0.02, 0.001


def described(
    shape: str, sizes: dict[str, Any], material: dict[str, Any], angles: dict[str, list[int]]
) -> dict[str, Any]:
    """A section of laminated walls: plies of equal thickness by wall, outermost first."""
    layers = {name: [1.0] * len(of) for name, of in angles.items()}
    return {
        **{"name": shape, "convention": "contour", "mesh": expand(shape, sizes, layers)},
        "materials": {"m": material},
        "regions": {
            wall.region: {
                "plies": [
                    {"material": "m", "angle_deg": float(angle)} for angle in angles[wall.region]
                ],
                "direction": wall.direction,
            }
            for wall in walls(shape, sizes)
        },
    }


def polygon(*, clockwise: bool) -> tuple[dict[str, Any], list[str]]:
    """The middle line of a box from its upper left corner on, and the names of its walls."""
    x, y = 0.5 * (WIDTH - WALL), 0.5 * (HEIGHT - WALL)
    points, names = [[-x, y], [x, y], [x, -y], [-x, -y], [-x, y]], list(ANGLES)
    if not clockwise:
        points, names = points[::-1], names[::-1]
    x2, x3 = zip(*points, strict=True)
    return {"x2": list(x2), "x3": list(x3), "wall": [WALL]}, names


@pytest.mark.parametrize("clockwise", [True, False])
def test_a_closed_line_is_a_box(clockwise: bool, record: Callable[[str, Any], None]) -> None:
    """Plies outermost first, in both directions of the line, to the estimated error of the mesh."""
    sizes, names = polygon(clockwise=clockwise)
    angles = {f"wall-{k}": ANGLES[name] for k, name in enumerate(names, 1)}
    found = analyse(described("polyline", sizes, CFRP, angles))
    box = {"width": WIDTH, "height": HEIGHT, "wall": WALL}
    expected = analyse(described("box", box, CFRP, ANGLES))
    assert scaled(found.K - expected.K, expected.K).max() < 5e-4
    np.testing.assert_allclose(found.M, expected.M, rtol=0, atol=1e-9 * np.abs(expected.M).max())
    record(f"polyline/{clockwise}/K", found.K)


def test_a_z_of_thin_walls(record: Callable[[str, Any], None]) -> None:
    """Second moments of its three rectangles; walls of different thickness."""
    b, h, f, w = 0.04, 0.06, 0.001, 0.0015  # flanges, height between their middles, thicknesses
    x2, x3 = [-b, 0.0, 0.0, b], [0.5 * h, 0.5 * h, -0.5 * h, -0.5 * h]
    sizes = {"x2": x2, "x3": x3, "wall": [f, w, f]}
    material = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}
    angles = {f"wall-{k}": [0] for k in (1, 2, 3)}
    K = analyse(described("polyline", sizes, material, angles)).K / 70e9
    # exact: flanges from their ends to the outer face of the web, the web between the flanges
    long, web = b + 0.5 * w, h - f
    area = 2 * f * long + w * web
    I2 = 2 * (long * f**3 / 12 + f * long * (0.5 * h) ** 2) + w * web**3 / 12
    centre = 0.5 * (b + 0.5 * w) - 0.5 * w
    I3 = 2 * (f * long**3 / 12 + f * long * centre**2) + web * w**3 / 12
    I23 = -2 * f * long * centre * 0.5 * h
    assert K[0, 0] == pytest.approx(area, rel=1e-6)
    assert K[4, 4] == pytest.approx(I2, rel=1e-6)
    assert K[5, 5] == pytest.approx(I3, rel=1e-6)
    assert K[4, 5] == pytest.approx(-I23, rel=1e-6)
    record("polyline/z/K", K)
