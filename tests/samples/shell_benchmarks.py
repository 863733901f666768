"""The entries of tests/reference/shells/benchmarks.toml as shell problems, and their numbers.

`numbers(id, n)` builds the specification of an entry on a mesh of meshes/shells and returns what
the entry's `quantity` asks for. Moduli of the non-dimensional plates are in units of E2 = 1.
"""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from samples.shell_cantilevers import box, cantilever
from samples.shell_model import Problem
from samples.shell_obstacle_course import (
    curved_beam,
    hemisphere,
    pinched_cylinder,
    scordelis,
    straight_beam,
    twisted_beam,
)
from samples.shell_squares import (
    angle_ply,
    barton_cantilever,
    barton_free,
    cantilever_square,
    clamped,
    cross_ply,
    cross_ply_by_modulus,
    cross_ply_by_thickness,
    free_plate,
    khdeir,
    lardeur,
    mindlin,
    strip,
    thick_plate,
)

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "tests" / "reference" / "shells" / "benchmarks.toml"
ENTRIES: dict[str, dict[str, Any]] = {
    entry["id"]: entry for entry in tomllib.loads(FILE.read_text(encoding="utf-8"))["benchmark"]
}


def tolerances(name: str) -> list[float]:
    """The numbers of an entry's `tolerance`, in order."""
    return [float(x) for x in re.findall(r"\d+(?:\.\d+)?e-\d+", ENTRIES[name]["tolerance"])]


def expected(name: str) -> Array:
    """Value or values of an entry."""
    return np.atleast_1d(np.array(ENTRIES[name]["value"], dtype=float))


def numbers(name: str, n: int | tuple[int, ...], **options: Any) -> Array:
    """What the entry's quantity asks for, by our elements.

    Parameters
    ----------
    n : cells along an edge, or along each of them
    options : `elements`, a table as in a description; `mesh`, more parameters of its script;
        `cells`, more keys of the table of the mesh
    """
    for pattern, family in FAMILIES.items():
        found = re.fullmatch(pattern, name)
        if found:
            model, read = family(n, *found.groups())
            return np.atleast_1d(np.asarray(read(model.solved(**options)), dtype=float))
    raise KeyError(f"{name}: no family of problems knows this entry")


FAMILIES: dict[str, Callable[..., Problem]] = {
    r"mindlin_ss_uniform_Lh(\d+)": mindlin,
    r"kirchhoff_clamped_uniform": clamped,
    r"fsdt_(sin|udl)_(\w+)_ah(\d+)": cross_ply,
    r"angle_45_m45_sin_ah(\d+)": angle_ply,
    r"khdeir_(\d+)ply_(\d+)": khdeir,
    r"freq_0_90_90_0_E(\d+)": cross_ply_by_modulus,
    r"freq_(\w+)_ah(\d+)": cross_ply_by_thickness,
    r"ssls504_lardeur": lardeur,
    r"r0031_1": strip,
    r"fv12": free_plate,
    r"fv16": cantilever_square,
    r"fv52": thick_plate,
    r"barton_cantilever": barton_cantilever,
    r"barton_free": barton_free,
    r"scordelis": scordelis,
    r"pinched_cyl": pinched_cylinder,
    r"hemisphere18": hemisphere,
    r"straight_(ext|in|out)": straight_beam,
    r"curved_in": curved_beam,
    r"twisted_(y|z)": twisted_beam,
    r"ccx_box_(\w+)": box,
    r"ccx_plate_(.+)": cantilever,
}


# Cells of each entry's mesh: those that its tolerance names, or those of its note.
MESHES: dict[str, int | tuple[int, ...]] = {
    r"scordelis": 16,
    r"straight_.*": (6, 1),
    r"curved_in": (12, 1),
    r"twisted_.": (48, 8),
    r"ccx_box_.*": (100, 8, 4),  # 4800 triangles
    r"ccx_plate_.*": (48, 12),
    r"r0031_1": (30, 4),
}


def mesh_of(name: str) -> int | tuple[int, ...]:
    """Cells on which an entry is asked for; 32 x 32 unless said otherwise."""
    return next((n for pattern, n in MESHES.items() if re.fullmatch(pattern, name)), 32)
