"""Complete specifications of bodies, from the entries that a test cares about."""

from typing import Any

from plymotion.solver.package.specification import DIRECTIONS

SHELL_PARTS = ("mesh", "materials", "laminates", "regions", "elements", "stiffeners")
CLAMPED = {"kind": "clamped", "at": "root"}


def beam_body(**entries: Any) -> dict[str, Any]:
    """A beam that is clamped at its interface "root", at the start."""
    return _with_directions(
        {
            "kind": "beam",
            "x2_axis": [0.0, 1.0, 0.0],
            "theory": "timoshenko",
            "mass_form": "consistent",
            "reference": CLAMPED,
            "damping_ratio": 0.0,
            "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
            **entries,
        }
    )


def shell_body(**entries: Any) -> dict[str, Any]:
    """A shell that is clamped at its interface "root"; interfaces are rigid unless they say so."""
    spec = {
        "kind": "shell",
        "mass_form": "consistent",
        "reference": CLAMPED,
        "damping_ratio": 0.0,
        **entries,
    }
    spec["shell"] = {"laminates": {}, "elements": {}, **spec["shell"]}
    plain = {"link": "rigid", "rotation_deg": [0.0, 0.0, 0.0]}
    spec["interfaces"] = {name: plain | table for name, table in spec["interfaces"].items()}
    return _with_directions(spec)


def shell_parts(shell: dict[str, Any]) -> dict[str, Any]:
    """The tables of a shell that its body has too: no supports, loads or results."""
    return {key: shell[key] for key in SHELL_PARTS if key in shell}


def panel_body(shell: dict[str, Any], n_mode: int, **entries: Any) -> dict[str, Any]:
    """The body of a plate: root at its left edge, tip at its right one, which may deform."""
    return shell_body(
        shell=shell_parts(shell),
        modes=[{"kind": "lowest", "count": n_mode}],
        interfaces={"root": {"at": "left"}, "tip": {"at": "right", "link": "average"}},
        **entries,
    )


def _with_directions(spec: dict[str, Any]) -> dict[str, Any]:
    """Attachment modes along and about all axes unless they say which."""
    every = {"directions": list(DIRECTIONS)}
    modes = [every | mode if mode["kind"] == "attachment" else mode for mode in spec["modes"]]
    return spec | {"modes": modes}
