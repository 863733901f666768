"""Cases with beams in segments, their packages built from given section matrices."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from samples.beam_samples import dense

from plymotion.preprocess.beam.beam_body import beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.line import LineSection
from plymotion.solver.inputs.case.bodies.specifications import BodySpecs
from plymotion.solver.inputs.case.checks import in_parts
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.package import ModalPackage, SectionData
from plymotion.solver.run.inputs import RunSpec

# Not used: matrices are given.
MATERIAL = {"kind": "isotropic", "E": 1.0, "nu": 0.0, "rho": 1.0, "strength": {"yield_stress": 1.0}}
SECTION = {"shape": "rectangle", "width": 0.1, "height": 0.1}


def run_of(
    table: Mapping[str, Any], matrices: tuple[np.ndarray, np.ndarray], name: str = "run"
) -> RunSpec:
    """A run of a case whose beams have the 6x6 stiffness and mass `matrices`."""
    whole = {"materials": {"m": MATERIAL}, "sections": {"s": SECTION}, **table}
    mechanism, specs, problems = in_parts(Mechanism.model_validate(whole), BodySpecs(Path()))
    assert problems == []
    built: dict[str, ModalPackage] = {}
    packages = {}
    for body, spec in specs.items():
        if spec.inputs_sha256 not in built:
            model = beam_model(read_spec(dict(spec.content)), LineSection(*matrices))
            section = SectionData("s", *matrices)
            modes = beam_modes(model, dense)
            assert modes.warnings == ()
            built[spec.inputs_sha256] = beam_package(model, modes, [section], {})
        packages[body] = built[spec.inputs_sha256]
    return RunSpec("case", name, mechanism, packages)


def cantilever(segments: int, length: float, **changes: Any) -> dict[str, Any]:
    """A beam clamped to the ground at the origin, along x."""
    body = {
        "kind": "beam",
        "length": length,
        "section": "s",
        "material": "m",
        "elements": 4 * segments,
        "segments": segments,
        "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
        **changes.pop("body", {}),
    }
    return {
        "bodies": {"beam": body},
        "ground": {"wall": {"position": [0.0, 0.0, 0.0]}},
        "joints": {"clamp": {"kind": "fixed", "between": ["ground.wall", "beam.root"]}},
        "signals": {
            f"tip_{axis}": {"kind": "deflection", "at": "beam.tip", "component": axis}
            for axis in "xyz"
        },
        "solver": {"t_end": 1.0, "output_step": 0.1, "geometric_stiffening": True},
        **changes,
    }


def on_hub(table: dict[str, Any], rim: float, speed: float = 1.0) -> dict[str, Any]:
    """The same beam on the rim of a hub that turns about z."""
    places = {"axis": {"position": [0.0, 0.0, 0.0]}, "rim": {"position": [rim, 0.0, 0.0]}}
    hub = {"kind": "rigid", "mass": 1.0, "inertia": np.eye(3).tolist(), "interfaces": places}
    turn = {"between": ["ground.wall", "hub.axis"], "drive": {"speed": speed}}
    root = {"kind": "fixed", "between": ["hub.rim", "beam.root"]}
    beam = table["bodies"]["beam"] | {"position": [rim, 0.0, 0.0]}
    return table | {
        "bodies": {"beam": beam, "hub": hub},
        "joints": {"axis": turn | {"kind": "revolute"}, "root": root},
    }
