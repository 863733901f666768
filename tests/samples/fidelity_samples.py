"""Planned runs of small mechanisms, whose rich packages need no FEniCSx."""

from dataclasses import replace
from typing import Any

import numpy as np
from samples.beam_samples import reduced
from samples.stiffening_samples import rectangle

from plymotion.solver.inputs.case.bodies.specifications import rich_bodies
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.package import ModalPackage
from plymotion.solver.package.body.selection import selected
from plymotion.solver.run.execution import execute
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.studies.fidelity.plan import with_values

Table = dict[str, Any]
Z = [0.0, 0.0, 1.0]
SIZES = {"stiff": (0.04, 0.01), "soft": (0.01, 0.04)}  # along the section's x2 and x3
INTERFACES = {"root": {"at": "start"}, "mid": {"at": 0.5}, "tip": {"at": "end"}}


def link(length: float, x: float) -> Table:
    """A beam along x; its section comes with the packages."""
    return {
        "kind": "beam",
        "length": length,
        "section": "bar",
        "material": "metal",
        "elements": 8,
        "modes": [{"kind": "bending-xy", "count": 1}],
        "position": [x, 0.0, 0.0],
        "interfaces": INTERFACES,
    }


def pendulum(links: int = 1, speed: float = 6.0, t_end: float = 0.4, **fidelity: Any) -> Table:
    """A chain of links of 0.6 m with a mass of 1 kg at its tip; the first is brought to a speed."""
    bodies = {f"link{i}": link(0.6, 0.6 * i) for i in range(links)}
    drive = {"polynomial": [0.0, 0.0, speed / (2.0 * t_end)]}
    places = ["ground.origin", *(f"link{i}.tip" for i in range(links))]
    joints: Table = {
        f"hinge{i}": {"kind": "revolute", "between": [places[i], f"link{i}.root"], "axis": Z}
        for i in range(links)
    }
    joints["hinge0"]["drive"] = drive
    bend = {"kind": "deflection", "at": "link0.tip", "component": "y"}
    return {
        "gravity": [0.0, -9.81, 0.0],
        "materials": {"metal": {"kind": "isotropic", "E": 73e9, "nu": 0.3, "rho": 2700.0}},
        "sections": {"bar": {"shape": "rectangle", "width": 0.04, "height": 0.01}},
        "bodies": bodies,
        "ground": {"origin": {"position": [0.0, 0.0, 0.0]}},
        "joints": joints,
        "masses": {"load": {"mass": 1.0, "at": places[-1]}},
        "signals": {
            "tip_x": {"kind": "position", "at": places[-1], "component": "x"},
            "tip_y": {"kind": "position", "at": places[-1], "component": "y"},
            "bending": bend,
            "force": {"kind": "reaction", "joint": "hinge0", "quantity": "force", "component": "x"},
        },
        "solver": {"t_end": t_end, "output_step": t_end / 200.0},
        "fidelity": {"accuracy": 1e-2, "signals": ["tip_x", "tip_y"], "budget": 60.0, **fidelity},
    }


def slider_crank(speed: float, t_end: float, **fidelity: Any) -> Table:
    """A rigid crank and slider with a rod of 0.6 m, which starts as its loads bend it."""
    made = pendulum(t_end=t_end, signals=["force"], **fidelity)
    del made["masses"]
    inertia = [[1e-4, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]]
    rigid: Table = {"kind": "rigid", "inertia": inertia}
    root, tip = {"position": [0.0, 0.0, 0.0]}, {"position": [0.12, 0.0, 0.0]}
    made["bodies"] = {
        "crank": {**rigid, "mass": 0.3, "interfaces": {"root": root, "tip": tip}},
        "link0": link(0.6, 0.12),
        "slider": {**rigid, "mass": 0.5, "position": [0.72, 0, 0], "interfaces": {"pin": root}},
    }
    made["ground"]["rail"] = {"position": [0.72, 0.0, 0.0]}
    motor, pin = ["ground.origin", "crank.root"], ["link0.tip", "slider.pin"]
    rail = {"between": ["ground.rail", "slider.pin"], "axis": [1.0, 0.0, 0.0]}
    made["joints"] = {
        "hinge0": {"kind": "revolute", "between": motor, "axis": Z, "drive": {"speed": speed}},
        "big_end": {"kind": "spherical", "between": ["crank.tip", "link0.root"]},
        "small_end": {"kind": "universal", "between": pin, "axis": Z, "axis_2": [0.0, 1.0, 0.0]},
        "guide": {"kind": "prismatic", **rail},
    }
    for name in ("tip_x", "tip_y"):
        made["signals"][name]["at"] = "link0.tip"
    made["solver"]["start"] = "quasi-static"
    return made


def planned_run(
    table: Table,
    side: str = "stiff",
    modulus: float = 73e9,
    *,
    without: str = "",
    elements: int | None = None,
) -> tuple[RunSpec, dict[str, ModalPackage]]:
    """A run with the rich packages of its model, and the packages of its check.

    `without` is a kind of modes, `elements` a mesh, of the packages of the model: omissions.
    """
    mechanism = Mechanism.model_validate(table)
    across, along = SIZES[side]
    K, mass = rectangle(modulus, 0.3, 2700.0, along, across)
    packages: list[dict[str, ModalPackage]] = [{}, {}]
    for name, body in mechanism.bodies.items():
        if body.kind != "beam":
            continue
        model, check = rich_bodies(name, mechanism)
        kept = [mode.model_dump() for mode in model.modes if mode.kind != without]
        every = [mode.model_dump() for mode in check.modes]
        meshes = (kept, elements or model.elements), (every, check.elements)
        for found, (modes, mesh) in zip(packages, meshes, strict=True):
            found[name] = reduced(
                {"kind": "clamped", "at": "root"},
                modes,
                elements=mesh,
                K=K,
                mass=mass,
                length=body.length,
                interfaces=INTERFACES,
                body=name,
            ).package
    return RunSpec("sample", "planned", mechanism, packages[0]), packages[1]


def chosen_modes(table: Table, side: str, modes: list[Table], **solver: Any) -> RunSpec:
    """A run of a scene without `[fidelity]`, with some modes of its rich packages."""
    spec, check = planned_run(table, side)
    changes = {f"solver.{key}": value for key, value in solver.items()}
    mechanism = spec.changed(changes).mechanism.model_copy(update={"fidelity": None})
    bodies = {n: b.model_copy(update={"reduced": None}) for n, b in mechanism.bodies.items()}
    spec = replace(spec, mechanism=mechanism.model_copy(update={"bodies": bodies}))
    spec = spec.changed({f"bodies.{name}.modes": modes for name in bodies})
    return replace(spec, packages={name: selected(p, modes) for name, p in check.items()})


def true_signals(table: Table, side: str, rtol: float, axial: int = 0) -> dict[str, np.ndarray]:
    """Signals with load shapes of the check and vibrations in its plane, `axial` of them along
    the links, stiffened: joint forces of a sudden start need axial ones, which take tiny steps."""
    spec, check = planned_run(table, side)
    asked = [
        {"kind": "bending-xy", "count": 6},
        *([{"kind": "axial", "count": axial}] if axial else []),
        {"kind": "attachment", "at": "tip", "directions": ["x", "y", "rz"]},
        {"kind": "static-inertia"},
    ]
    packages = {n: selected(package, asked) for n, package in check.items()}
    solver = with_values(spec.mechanism.solver, rtol=rtol, geometric_stiffening=True)
    mechanism = with_values(spec.mechanism, solver=solver)
    result, _ = execute(replace(spec, mechanism=mechanism, packages=packages), progress=False)
    return {signal.name: signal.values for signal in result.signals}
