"""A pendulum with [fidelity] as a case file, with packages built here instead of by FEniCSx."""

import json
from dataclasses import replace
from pathlib import Path

from samples.beam_samples import reduced
from samples.stiffening_samples import rectangle

from plymotion.solver.package import write_package

CASE = """
format = 1
title = "Pendulum"
gravity = [0.0, -9.81, 0.0]
materials.metal = { kind = "isotropic", E = 73e9, nu = 0.3, rho = 2700.0 }
sections.bar = { shape = "rectangle", width = 0.01, height = 0.04 }
ground.origin = { position = [0.0, 0.0, 0.0] }
masses.load = { mass = 1.0, at = "link.tip" }
signals.tip = { kind = "position", at = "link.tip", component = "y" }
signals.force = { kind = "reaction", joint = "hinge", quantity = "force", component = "x" }
solver = { t_end = 0.1, output_step = 0.002 }
fidelity = { accuracy = 1e-2, signals = ["tip"] }

[bodies.link]
kind = "beam"
length = 0.6
section = "bar"
material = "metal"
elements = 8
modes = [{ kind = "bending-xy", count = 2 }]
interfaces = { root = { at = "start" }, tip = { at = "end" } }

[joints.hinge]
kind = "revolute"
between = ["ground.origin", "link.root"]
axis = [0.0, 0.0, 1.0]
drive = { polynomial = [0.0, 0.0, 8.0] }

[variants.impossible]
fidelity = { accuracy = 1e-9, signals = ["force"], budget = 0.05 }
solver = { t_end = 0.003 }

[runs.base]
[runs.impossible]
variants = ["impossible"]
"""


def build_bodies(specs: Path, out: Path) -> None:
    """Build the packages of all specifications of a folder."""
    K, mass = rectangle(73e9, 0.3, 2700.0, 0.04, 0.01)
    for file in specs.glob("*.json"):
        spec = json.loads(file.read_text())
        package = reduced(
            spec["reference"],
            spec["modes"],
            elements=spec["elements"],
            K=K,
            mass=mass,
            length=spec["length"],
            interfaces=spec["interfaces"],
            body=spec["body"],
        ).package
        known = {**package.provenance, "inputs_sha256": spec["inputs_sha256"]}
        write_package(out / f"{file.stem}.vtkhdf", replace(package, provenance=known))
