"""The neutral description of a mechanism: bodies as they start, joints, gravity, probe."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from solver_exudyn import reduced
from solver_problems import interface, node, write_run

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.schema import changed_mechanism
from plymotion.solver.math.rotations import rotation_matrix, skew
from plymotion.solver.package import read_package, write_package
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.preparation import prepare

if TYPE_CHECKING:
    from scenes import Scene

FOLDER = Path("build/arena/runs")
SOLVER = ("start", "modes_at_start", "on_invalid", "on_singular", "geometric_stiffening")


def beams(scene: "Scene") -> dict[str, Any]:
    """Sheet of a scene whose script has `table(n)`, `matrices` and, for other codes, `beam`.

    Packages are made from the 6x6 stiffness and mass, one run file for each number of segments or
    modes.
    """
    from samples.segment_samples import run_of

    table, script, files = scene.table, scene.script, {}
    assert script is not None
    every = table.get("every", 0.01)
    t_end = table.get("t_end", every)  # of modes: not run
    for n in table["ours"]["segments" if scene.motion else "modes"]:
        spec = run_of(script.table(n), script.matrices)
        case = spec.mechanism.model_dump()
        solver = {key: case["solver"][key] for key in SOLVER}
        case["solver"] = solver | {"t_end": t_end, "output_step": every}
        packages = {}
        for body, package in spec.packages.items():
            packages[body] = FOLDER / scene.name / f"{n}-{body}.vtkhdf"
            packages[body].parent.mkdir(parents=True, exist_ok=True)
            write_package(packages[body], package)
        files[n] = write_run(f"{scene.name}-{n}", case, packages, FOLDER)
    found: dict[str, Any] = {"run_files": files}
    if scene.motion:
        found |= {"times": scene.times, "every": every, "t_end": t_end, "beam": script.beam}
    return dict(listed(found))


def mechanism(scene: "Scene") -> dict[str, Any]:
    """Entries of the sheet of a scene of kind `mechanism`."""
    table = scene.table
    if hasattr(scene.script, "matrices"):
        return beams(scene)
    runs = load_case(scene.case()).runs
    name = table.get("run", next(iter(runs)))
    if name not in runs:
        raise SystemExit(f"{scene.name}: run = {name!r}: expected one of {', '.join(runs)}")
    case = changed_mechanism(runs[name], table.get("changes", {})).model_dump()
    solver = {key: case["solver"][key] for key in SOLVER}
    every = table.get("every", 0.01)
    case["solver"] = solver | {"t_end": table["t_end"], "output_step": every}
    case["fidelity"] = None
    case["signals"] = {
        axis: {"kind": "position", "at": table["probe"], "component": axis} for axis in "xyz"
    }
    packages = {}
    if "packages" in table:
        folder = scene.path(table["packages"])
        for body, entry in case["bodies"].items():
            if entry["kind"] != "rigid":
                own = [folder / f"{n}.vtkhdf" for n in (f"{body}.{name}", body)]
                own += sorted(folder.glob(f"{body}.*.vtkhdf"))
                packages[body] = next(p for p in own if p.exists())
    file = write_run(scene.name, case, packages, FOLDER)
    spec = read_run(file)
    ready = prepare(spec.mechanism, spec.packages)
    model, y0 = ready.model, ready.y0
    frames, bodies = {}, []
    for k, (body, entry) in enumerate(case["bodies"].items()):
        p, v = y0[int(model.pos_start[k]) :], y0[model.n_pos + int(model.vel_start[k]) :]
        R = rotation_matrix(p[3:7])
        frames[body] = (k, p[:3], R)
        bodies.append(
            {
                "name": body,
                "position": p[:3],
                "rotation": R,
                "velocity": v[:3],
                "spin_body": v[3:6],
            }
        )
        if body in packages:
            package = read_package(packages[body])
            points = {i.name: i.position_B for i in package.interfaces}
            nodes = {i: node(package, i) for i in points}
            arrays = dict(vars(reduced(package, masses(case, body))))
            corners, rows = virtual(package)
            arrays["nodes"] = np.vstack([arrays["nodes"], corners])
            arrays["basis"] = np.vstack([arrays["basis"], rows])
            first = {i: len(package.nodes_B) + 6 * k for k, i in enumerate(points)}
            npz = FOLDER / scene.name / f"{body}.npz"
            np.savez(npz, **{key: np.asarray(value) for key, value in arrays.items()})
            shapes = {i: np.abs(interface(package, i).phi_B).max() for i in points}
            held = [i for i in points if shapes[i] < 1e-12 and not np.any(points[i])]
            bodies[-1] |= {
                "modal": str(npz),
                "nodes": nodes,
                "points": points,
                "held": held,
                "corners": {i: list(range(n, n + 6)) for i, n in first.items()},
                "modal_start": p[7 : 7 + package.n_mode],
                "modal_rates": v[6 : 6 + package.n_mode],
            }
        else:
            bodies[-1] |= {
                "mass": entry["mass"],
                "centre": entry["centre"],
                "inertia": about_origin(entry),
                "points": {n: i["position"] for n, i in entry["interfaces"].items()},
            }
    ground = {n: g["position"] for n, g in case["ground"].items()}

    def place(at: str) -> dict[str, Any]:
        body, point = at.split(".", 1)
        if body == "ground":
            return {"body": -1, "point": ground[point], "at": point, "global": ground[point]}
        k, r, R = frames[body]
        local = np.asarray(bodies[k]["points"][point])
        return {"body": k, "point": local, "at": point, "global": r + R @ local}

    joints = []
    for name, joint in case["joints"].items():
        one, two = (place(at) for at in joint["between"])
        joints.append(joint | {"name": name, "one": one, "two": two})
    return listed(
        {
            "run_file": file,
            "times": scene.times,
            "every": every,
            "t_end": table["t_end"],
            "gravity": case["gravity"] or [0.0, 0.0, 0.0],
            "bodies": bodies,
            "joints": joints,
            "forces": case["forces"],
            "masses": case["masses"],
            "couplings": case["couplings"],
            "probe": place(table["probe"]),
        }
    )


def virtual(package: Any) -> tuple[Any, Any]:
    """Six places about each interface that move with it, for codes that have no rotations of nodes.

    Places (6 i, 3) [m] and rows of the mode basis (18 i, m).
    """
    arm = 0.01 * float(np.ptp(package.nodes_B, axis=0).max())
    offsets = arm * np.vstack([np.eye(3), -np.eye(3)])
    places = [i.position_B + d for i in package.interfaces for d in offsets]
    rows = [i.phi_B - skew(d) @ i.psi_B for i in package.interfaces for d in offsets]
    return np.array(places), np.vstack(rows)


def masses(case: dict[str, Any], body: str) -> dict[str, float]:
    """Point masses on the interfaces of a body, interface -> kg."""
    found = {}
    for entry in (case["masses"] or {}).values():
        at = entry["at"].split(".", 1)
        if at[0] == body:
            found[at[1]] = float(entry["mass"])
    return found


def about_origin(entry: dict[str, Any]) -> Any:
    """Inertia of a rigid body about the centre of mass -> about the origin of its frame."""
    c = np.asarray(entry["centre"])
    return np.asarray(entry["inertia"]) + entry["mass"] * (c @ c * np.eye(3) - np.outer(c, c))


def listed(value: Any) -> Any:
    """Arrays as lists and paths as text, for JSON."""
    if isinstance(value, dict):
        return {str(key): listed(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [listed(v) for v in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return str(value) if isinstance(value, Path) else value
