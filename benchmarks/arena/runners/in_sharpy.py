"""SHARPy: geometrically exact beams of three nodes; a dead force and a turning root.

All its forces follow their nodes except weight: the dead force at a tip is the weight of a point
mass, in eight parts. Orientations of nodes are set: its loader has tangents of the order start,
middle, end, elements that of start, end, middle, and curved beams do not converge with it. Its
structural solvers run without DynamicCoupled, which needs a flow. Newmark without damping.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
from common import Sheet, Timed, main

NAME = "SHARPy"
PACKAGES = "h5py configobj sympy matplotlib colorama dill pandas control openpyxl lxml PySocks"
ENVIRONMENT: dict[str, Any] = {
    "pip": [*PACKAGES.split(), "PyYAML", "jax", "mayavi", "numpy<2", "scipy<1.14"],
    "alone": ["ic-sharpy==2.4"],  # asks for JupyterLab, too
}


def cannot(sheet: Sheet) -> str:
    """One beam on a wall or a hub."""
    if "beam" not in sheet:
        return "a code of beams: other bodies and sections not in this runner"
    return "its forces follow their nodes" if "moment" in sheet["beam"] else ""


def settings(sheet: Sheet) -> list[Sheet]:
    """Elements, and steps with their square: errors are of fourth and of second order."""
    if sheet["beam"].get("static"):
        return [{"method": "geometrically exact", "elements": n} for n in (2, 4, 8, 16, 32)]
    first = max(len(sheet["times"]), round(100 * sheet["t_end"])) // 16
    return [
        {"method": "geometrically exact", "elements": n, "steps": first * n * n}
        for n in (2, 4, 6, 8)
    ]


def beam(sheet: Sheet, n: int, options: Sheet) -> Any:
    """A clamped beam of n elements; its middle node is the last of each."""
    from sharpy.structure.models.beam import Beam

    b = sheet["beam"]
    s = np.linspace(0.0, b["length"], 2 * n + 1)
    a = b.get("curvature", [0.0] * 3)[2] * s
    places = [s * np.sinc(a / np.pi), s * np.sinc(a / (2 * np.pi)) * np.sin(a / 2), 0.0 * s]
    K = np.array(b.get("K", np.diag([b.get(k, 0.0) for k in ("EA", "GA", "GA", "EI", "EI", "EI")])))
    rotary = b.get("rotary", 1e-9)
    M = np.diag([b.get("mass", 1e-9)] * 3 + [2.0 * rotary, rotary, rotary])
    ends = np.zeros(2 * n + 1, dtype=int)
    ends[[0, -1]] = 1, -1
    across = np.stack([-np.sin(a), np.cos(a), 0.0 * s], axis=1)  # the local y
    own = np.array([[2 * k, 2 * k + 2, 2 * k + 1] for k in range(n)])
    given = {
        "num_node": 2 * n + 1, "num_elem": n, "num_node_elem": 3, "coordinates": np.array(places).T,
        "connectivities": own, "stiffness_db": K[None], "elem_stiffness": np.zeros(n, int),
        "mass_db": M[None], "elem_mass": np.zeros(n, int), "structural_twist": np.zeros((n, 3)),
        "frame_of_reference_delta": across[own], "boundary_conditions": ends,
        "beam_number": np.zeros(n, int), "app_forces": np.zeros((2 * n + 1, 6)),
    }  # fmt: skip
    if "force" in b:
        size = float(np.linalg.norm(b["force"]))
        options |= {"gravity_on": True, "gravity": 1.0}
        options["gravity_dir"] = (-np.array(b["force"]) / size).tolist()
        given |= {
            "lumped_mass": np.array([size]), "lumped_mass_nodes": np.array([2 * n]),
            "lumped_mass_inertia": np.zeros((1, 3, 3)), "lumped_mass_position": np.zeros((1, 3)),
        }  # fmt: skip
    found = Beam()
    found.generate(given, {"orientation": np.array([1.0, 0, 0, 0]), "for_pos": np.zeros(3),
                           "unsteady": False})  # fmt: skip
    found.ini_info.psi[..., 2] = a[own]
    found.timestep_info[0].psi[:] = found.fortran["psi_ini"][:] = found.ini_info.psi
    return found


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Build and solve; positions of the end of the beam at the outputs."""
    import sharpy.solvers  # noqa: F401  (lists them)
    from sharpy.utils.solver_interface import initialise_solver

    options: Sheet = {"print_info": False, "newmark_damp": 0.0, "min_delta": 1e-8}
    data = SimpleNamespace(ts=0, settings={}, structure=beam(sheet, setting["elements"], options))
    if sheet["beam"].get("static"):
        with Timed() as used:
            solver = initialise_solver("NonLinearStatic", print_info=False)
            for part in np.linspace(0.125, 1.0, 8):
                solver.initialise(data, options | {"gravity": part})
                solver.run()
        return [data.structure.timestep_info[0].pos[-1].tolist()], used.seconds
    each = max(1, round(setting["steps"] / len(sheet["times"])))
    dt = sheet["every"] / each
    steps = each * len(sheet["times"])
    t, T = dt * np.arange(1, steps + 1), sheet["beam"]["spin_up"]["duration"]
    speed, s = sheet["beam"]["spin_up"]["speed"], np.minimum(t / T, 1.0)
    data.structure.dyn_dict = {"for_vel": np.zeros((steps, 6)), "for_acc": np.zeros((steps, 6))}
    data.structure.dyn_dict["for_vel"][:, 5] = speed * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
    data.structure.dyn_dict["for_acc"][:, 5] = speed / T * (1 - np.cos(2 * np.pi * s))
    turned = speed * T * (s * s / 2 + (np.cos(2 * np.pi * s) - 1) / (4 * np.pi**2))
    turned += speed * np.maximum(t - T, 0.0)
    rows = []
    with Timed() as used:
        solver = initialise_solver("NonLinearDynamicPrescribedStep", print_info=False)
        solver.initialise(data, options | {"dt": dt, "num_steps": steps})
        now = data.structure.timestep_info[0]
        for data.ts in range(1, steps + 1):
            solver.run(structural_step=now)
            if data.ts % each == 0:
                x, y, _ = now.pos[-1]
                c, d = np.cos(turned[data.ts - 1]), np.sin(turned[data.ts - 1])
                rows.append([c * x - d * y, d * x + c * y, 0.0])
    return rows, used.seconds


if __name__ == "__main__":
    main(solve)
