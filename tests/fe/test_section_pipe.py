"""The multi-layer composite pipe of the VABS papers: flat walls [90/0], round ends [45/-45].

Values as in the tests of GXBeam.jl (test/section.jl), which names the paper "Generalized Timoshenko
Theory of the Variational Asymptotic Beam Sectional Analysis"; in lb and in.
"""

from pathlib import Path

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse

PUBLISHED = {
    (1, 1): 1.03892e7,
    (2, 2): 7.85310e5,
    (3, 3): 3.29279e5,
    (1, 4): 9.84575e4,
    (2, 5): -8.21805e3,
    (3, 6): -5.20981e4,
    (4, 4): 6.87275e5,
    (5, 5): 1.88238e6,
    (6, 6): 5.38987e6,
}
LAMINA = {
    "kind": "orthotropic",
    **{"E1": 20.59e6, "E2": 1.42e6, "E3": 1.42e6, "G12": 0.87e6, "G13": 0.87e6, "G23": 0.87e6},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1.0},
}
# name: first and last corner, centre of the arc, layer direction, angles of the inner and outer ply
WALLS = {
    "top": ((-1, 1), (1, 1), None, {"vector": [1.0, 0.0]}, (90.0, 0.0)),
    "right": ((1, 1), (1, -1), 1, {"circle": [1.0, 0.0]}, (45.0, -45.0)),
    "bottom": ((1, -1), (-1, -1), None, {"vector": [-1.0, 0.0]}, (90.0, 0.0)),
    "left": ((-1, -1), (-1, 1), -1, {"circle": [-1.0, 0.0]}, (45.0, -45.0)),
}
RADII = (0.3, 0.4, 0.5)


def script() -> str:
    """Flat walls of length 2 at x3 = 0.3 to 0.5, and half rings about (1, 0) and (-1, 0)."""
    lines = ["Mesh.ElementOrder = 2;", "Point(1) = {-1, 0, 0};", "Point(2) = {1, 0, 0};"]
    number: dict[tuple[float, float], int] = {}

    def point(x: float, y: float) -> int:
        if (x, y) not in number:
            number[x, y] = len(number) + 3
            lines.append(f"Point({number[x, y]}) = {{{x}, {y}, 0}};")
        return number[x, y]

    def curve(name: str, a: int, b: int, centre: int | None, cells: int) -> None:
        line = f"Line(c) = {{{a}, {b}}};"
        arc = f"Circle(c) = {{{a}, {2 if centre == 1 else 1}, {b}}};"
        lines.append(f"c = newl; {line if centre is None else arc}")
        lines.append(f"Transfinite Curve {{c}} = {cells + 1}; {name} = c;")

    for name, (first, last, centre, _, _) in WALLS.items():
        for row in (0, 1):
            faces = []
            for r in RADII[row : row + 2]:
                middle = [] if centre is None else [point(centre * (1.0 + r), 0.0)]
                faces.append([point(first[0], r * first[1]), *middle, point(last[0], r * last[1])])
            made = []
            for k in range(len(faces[0]) - 1):
                cells = 16 if centre is None else 8
                curve("inner", faces[0][k], faces[0][k + 1], centre, cells)
                curve("outer", faces[1][k], faces[1][k + 1], centre, cells)
                curve("start", faces[0][k], faces[1][k], None, 2)
                curve("end", faces[0][k + 1], faces[1][k + 1], None, 2)
                made.append(f"s{k}")
                lines.append("l = newll; Curve Loop(l) = {inner, end, -outer, -start};")
                lines.append(f"s{k} = news; Plane Surface(s{k}) = {{l}};")
                lines.append(f"Transfinite Surface {{s{k}}}; Recombine Surface {{s{k}}};")
            lines.append(f'Physical Surface("{name}-{row}") = {{{", ".join(made)}}};')
    return "\n".join([*lines, "Coherence;"]) + "\n"


@pytest.mark.one_end
def test_published_stiffness(tmp_path: Path) -> None:
    path = tmp_path / "pipe.geo"
    path.write_text(script())
    regions = {
        f"{name}-{row}": {
            "plies": [{"material": "lamina", "angle_deg": angles[row]}],
            "direction": direction,
        }
        for name, (_, _, _, direction, angles) in WALLS.items()
        for row in (0, 1)
    }
    found = analyse(
        {
            "convention": "contour",
            "mesh": {"file": str(path)},
            "materials": {"lamina": LAMINA},
            "regions": regions,
        },
        estimate=False,
    )
    size = np.sqrt(np.diag(found.K))
    for (i, j), value in PUBLISHED.items():
        ours, scale = found.K[i - 1, j - 1], size[i - 1] * size[j - 1]
        assert ours == pytest.approx(value, abs=5e-4 * scale), (i, j)
