"""Bounds over all lay-ups of ten shells: build/benchmarks/shell-bounds.json.

python benchmarks/shell_bounds.py build/benchmarks/shell-bounds.json
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

from plymotion.preprocess.shell.analyses.shell_analysis import analyse

SHELLS = Path("meshes/shells").absolute()
PLY = {
    "kind": "orthotropic",
    **{"E1": 138e9, "E2": 8.96e9, "E3": 8.96e9, "G12": 7.1e9, "G13": 7.1e9, "G23": 7.1e9},
    **{"nu12": 0.3, "nu13": 0.3, "nu23": 0.3, "rho": 1500.0},
}
SIDES = ("left", "right", "bottom", "top")
PUSH = {
    "compression": {"right": [-1.0, 0.0, 0.0], "left": [1.0, 0.0, 0.0]},
    "shear": {"right": [0.0, 1.0, 0.0], "left": [0.0, -1.0, 0.0],
              "top": [1.0, 0.0, 0.0], "bottom": [-1.0, 0.0, 0.0]},
}  # fmt: skip
ROOF = {
    "far": {"at": "far", "fixed": ["uy", "uz"]},
    "near": {"at": "near", "fixed": ["ux", "ry", "rz"]},
    "first": {"at": "first", "fixed": ["uy", "rx", "rz"]},
}
ARCH = {"radius": 1.0, "length": 1.0, "first_deg": -30.0, "second_deg": 30.0}


def shell(script: str, sizes: Any, plies: int, h: float, of: str, **tables: Any) -> dict[str, Any]:
    """A shell of symmetric [0] plies, a poor lay-up for most."""
    ply = {"material": "ply", "angle_deg": 0.0, "thickness": h / plies}
    return {
        "name": script,
        "mesh": {"file": str(SHELLS / f"{script}.py"), "parameters": sizes},
        "materials": {"ply": PLY},
        "laminates": {"wall": {"plies": [ply] * plies}},
        "regions": {"all": {"laminate": "wall", "axis": [1.0, 0.0, 0.0]}},
        "bound": of,
        "bound_angles_deg": [0.0, 45.0, -45.0, 90.0],
        **tables,
    }


def flat(edges: str, of: str, ratio: float = 1.0, plies: int = 8, **tables: Any) -> dict[str, Any]:
    """A plate, 1 m long, `ratio` wide and 1 mm thick; edges s, c or f."""
    supports: dict[str, Any] = {}
    for name, kind in zip(SIDES, edges, strict=True):
        along, across = ("rx", "ry") if name in SIDES[:2] else ("ry", "rx")
        fixed = ["uz", along] + ([across] if kind == "c" else [])
        if kind != "f":
            supports[name] = {"at": name, "fixed": fixed}
    if of == "buckling":
        supports = {name: {**each, "only": "modes"} for name, each in supports.items()}
        supports["flat"] = {"at": "plate", "fixed": ["uz", "rx", "ry"], "only": "loads"}
        tables["buckling"] = {"count": 1, "in_plane": False}
        tables["loads"] = {"N": {k: {"at": k, "force_per_length": f}
                                 for k, f in PUSH[tables.pop("load")].items()}}  # fmt: skip
    supports["middle"] = {"at": "centre", "fixed": ["ux", "uy"]}
    supports["level"] = {"at": "right-middle", "fixed": ["uy"]}
    sizes = {"length": 1.0, "width": ratio, "n_length": 20, "n_width": max(int(20 * ratio), 8)}
    return shell("plate", sizes, plies, 1e-3, of, supports=supports, **tables)


def shells() -> dict[str, dict[str, Any]]:
    """The ten shells."""
    pressure = {"q": {"p": {"at": "plate", "force_per_area": [0.0, 0.0, 1.0]}}}
    weight = {"w": {"all": {"gravity": [0.0, 0.0, -9.81]}}}
    clamped = {name: {"at": name, "fixed": "all"} for name in ("near", "far", "first", "second")}
    return {
        "square, simply supported, frequency": flat("ssss", "frequency"),
        "square, clamped, frequency": flat("cccc", "frequency"),
        "cantilever, frequency": flat("cfff", "frequency"),
        "1 : 0.7, two edges clamped, frequency": flat("ccss", "frequency", 0.7),
        "1 : 0.7, 16 plies, compression, buckling": flat(
            "ssss", "buckling", 0.7, 16, load="compression"
        ),
        "1 : 0.7, shear, buckling": flat("ssss", "buckling", 0.7, load="shear"),
        "square, clamped, pressure, compliance": flat("cccc", "compliance", loads=pressure),
        "roof (Scordelis, Lo), weight, compliance": shell(
            "cylinder", {}, 8, 0.25, "compliance", supports=ROOF, loads=weight
        ),
        "roof, frequency": shell("cylinder", {}, 8, 0.25, "frequency", supports=ROOF),
        "arch, clamped, 16 plies, frequency": shell(
            "cylinder", ARCH, 16, 5e-3, "frequency", supports=clamped
        ),
    }


def main() -> None:
    """Compute all and write the file that the command line names."""
    found = {}
    for name, spec in shells().items():
        plain = {key: value for key, value in spec.items() if not key.startswith("bound")}
        plain.setdefault("frequencies", {"count": 1, "error": False})
        begin = time.process_time()
        analyse(plain)
        between = time.process_time()
        table = analyse({**plain, **spec}).provenance["bound"]
        seconds = time.process_time() - between - (between - begin)
        found[name] = {**table, "cpu_s": round(seconds, 2)}
        best = table["of_angles"]
        print(f"{name}: {table['bound']:.5g} {table['unit']}, found {table['found']:.5g}, "
              f"gap {100 * table['found_gap']:.2g} %; of four angles {best['best']:.5g}, "
              f"gap {100 * best['gap']:.2g} %, {best['branches']} branches, {best['computed']} of "
              f"{best['lay_ups']} computed; {seconds:.1f} s")  # fmt: skip
    out = Path(sys.argv[1])
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
