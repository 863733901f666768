"""Complete specifications of bodies, from the entries that a test cares about."""

from typing import Any

from plymotion.solver.package.body.specification import DIRECTIONS

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


def _with_directions(spec: dict[str, Any]) -> dict[str, Any]:
    """Attachment modes along and about all axes unless they say which."""
    every = {"directions": list(DIRECTIONS)}
    modes = [every | mode if mode["kind"] == "attachment" else mode for mode in spec["modes"]]
    return spec | {"modes": modes}
