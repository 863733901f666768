"""One steady point of IEA-15-240-RWT by SHARPy: beams of large rotation in a free vortex wake.

    python3 -m venv build/sharpy
    build/sharpy/bin/python -m pip install --no-deps ic-sharpy==2.4
    build/sharpy/bin/python -m pip install "numpy<2" "scipy<1.14" h5py configobj sympy matplotlib \
        colorama dill pandas control openpyxl lxml PySocks PyYAML jax mayavi
    build/sharpy/bin/python benchmarks/sharpy_point.py build/benchmarks/wind/turbine

The folder is that of `plymotion blade IEA-15-240-RWT.yaml --stations 21 --rotor`, as `make wind`
leaves it. The rotor alone, without tilt, shear, weight and tower. Half an hour
(docs/rotor-accuracy.md).
"""

import csv
import math
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy as np
import sharpy.sharpy_main
from configobj import ConfigObj
from scipy.interpolate import CubicSpline
from sharpy.utils import algebra

BLADES, ELEMENTS, PANELS = 3, 10, 2
WIND, OMEGA = 8.0, 5.73 * math.pi / 30.0  # [m/s], [rad/s]; pitch 0
STEPS, TURNS, WAKE = 48, 4, 3  # steps a turn; turns of the run and of the wake
DT = 2.0 * math.pi / STEPS / OMEGA


def columns(file):
    """Return the columns of a file by their names, numbers as arrays."""
    rows = list(csv.DictReader(x for x in file.read_text().splitlines() if x[0] != "#"))
    return {
        key: np.array([r[key] if key in {"place", "polar"} else float(r[key]) for r in rows])
        for key in rows[0]
    }


def matrices(table, letter, places, at):
    """Return the 6x6 of a table at places, linear between its stations."""
    found = np.empty((len(at), 6, 6))
    for i, j in zip(*np.triu_indices(6), strict=True):
        found[:, i, j] = np.interp(at, places, table[f"{letter}{i + 1}{j + 1}"])
        found[:, j, i] = found[:, i, j]
    return found


def camber(polar):
    """Return a parabola that has the angle of zero lift of a polar."""
    inside = np.abs(polar[:, 0]) < 0.3
    alpha, cl = polar[inside, :2].T
    up = np.flatnonzero((cl[:-1] < 0.0) & (cl[1:] >= 0.0))
    k = up[np.argmin(np.abs(alpha[up]))] if up.size else 0
    zero = float(np.interp(0.0, cl[k : k + 2], alpha[k : k + 2])) if up.size else 0.0
    x = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 500))
    return np.column_stack([x, -2.0 * zero * x * (1.0 - x)])


def write(source, folder):
    """Write the files of SHARPy; return the axes of the first blade."""
    beam, strips, rows = (columns(source / f"{k}.csv") for k in ("beam", "aero", "polars"))
    case = tomllib.loads((source / "rotor.toml").read_text())
    line = np.column_stack([beam["x_m"], beam["y_m"], beam["z_m"]])
    places = np.cumsum([0.0, *np.linalg.norm(np.diff(line, axis=0), axis=1)])
    places /= places[-1]
    s = np.linspace(0.0, 1.0, 2 * ELEMENTS + 1)
    s = 0.5 * s + 0.5 * np.sin(0.5 * np.pi * s)  # closer at the tip
    at = [case["bodies"]["blade-1"]["interfaces"][name]["at"] for name in strips["place"]]
    chord, ahead = (np.interp(s, at, strips[key]) for key in ("chord", "offset"))
    keys = ("alpha_deg", "cl", "cd", "cm")
    given = [[rows[k][rows["polar"] == name] for k in keys] for name in strips["polar"]]
    polars = CubicSpline(at, given)(np.clip(s, at[0], at[-1])).swapaxes(1, 2)
    polars[:, :, 0] = np.radians(polars[:, :, 0])
    x, _, z = case["bodies"]["hub"]["interfaces"]["blade-1"]["position"]
    cone = algebra.rotation_matrix_around_axis(np.array([0.0, 1.0, 0.0]), math.atan2(-x, z))
    turns = [
        algebra.rotation_matrix_around_axis(np.array([0.0, 0.0, 1.0]), 2.0 * math.pi * k / BLADES)
        for k in range(BLADES)
    ]
    hub = np.array([math.hypot(x, z), 0.0, 0.0])
    nodes = (CubicSpline(places, line)(s) + hub) @ cone.T
    n, total = len(s), BLADES * ELEMENTS
    own = np.array([[2 * k, 2 * k + 2, 2 * k + 1] for k in range(ELEMENTS)])  # the middle last

    def all_blades(values):
        return np.concatenate([np.asarray(values)[own]] * BLADES)

    ends = np.zeros(n, dtype=int)
    ends[[0, -1]] = 1, -1
    index = np.tile(np.arange(ELEMENTS), BLADES)
    blown = np.arange(n) >= 2
    structure = {
        "num_node": BLADES * n, "num_elem": total, "num_node_elem": 3,
        "coordinates": np.concatenate([nodes @ turn.T for turn in turns]),
        "connectivities": np.concatenate([own + k * n for k in range(BLADES)]),
        "stiffness_db": matrices(beam, "K", places, s[1::2]), "elem_stiffness": index,
        "mass_db": matrices(beam, "M", places, s[1::2]), "elem_mass": index,
        "frame_of_reference_delta": np.repeat(
            [(t @ cone)[:, 1] for t in turns], 3 * ELEMENTS, axis=0).reshape(total, 3, 3),
        "structural_twist": all_blades(np.radians(np.interp(s, places, beam["twist_deg"]))),
        "boundary_conditions": np.tile(ends, BLADES), "body_number": np.zeros(total, int),
        "beam_number": np.repeat(np.arange(BLADES), ELEMENTS),
        "app_forces": np.zeros((BLADES * n, 6)),
    }  # fmt: skip
    air = {
        "aero_node": np.tile(blown, BLADES), "chord": all_blades(chord),
        "twist": np.zeros((total, 3)), "sweep": np.full((total, 3), math.pi),
        "surface_m": np.full(BLADES, PANELS), "m_distribution": b"uniform",
        "surface_distribution": np.where(
            blown[own].all(axis=1), np.arange(BLADES)[:, None], -1).ravel(),
        "elastic_axis": all_blades(0.25 + ahead / chord), "first_twist": [True] * BLADES,
        "airfoil_distribution": all_blades(np.arange(n)),
        **{f"polars/{k}": polar for k, polar in enumerate(polars)},
        **{f"airfoils/{k}": camber(polar) for k, polar in enumerate(polars)},
    }  # fmt: skip
    steps = TURNS * STEPS
    motion = {"num_steps": steps, "dynamic_forces": np.zeros((steps, BLADES * n, 6)),
              "for_vel": np.tile([0.0, 0.0, 0.0, 0.0, 0.0, OMEGA], (steps, 1)),
              "for_acc": np.zeros((steps, 6))}  # fmt: skip
    for name, table in (("fem", structure), ("aero", air), ("dyn", motion)):
        with h5py.File(folder / f"point.{name}.h5", "w") as file:
            for key, value in table.items():
                file[key] = value
    return cone


def settings(folder):
    """Write the settings of SHARPy; return their file."""
    flow = {"u_inf": WIND, "u_inf_direction": [0.0, 0.0, 1.0]}
    file = ConfigObj()
    file.filename = str(folder / "point.sharpy")
    file["SHARPy"] = {"case": "point", "route": str(folder), "write_screen": False,
                      "log_folder": str(folder),
                      "flow": ["BeamLoader", "AerogridLoader", "DynamicCoupled"]}  # fmt: skip
    file["BeamLoader"] = {"unsteady": True}
    file["AerogridLoader"] = {
        "unsteady": True, "aligned_grid": False, "initial_align": False,
        "mstar": WAKE * STEPS,
        "freestream_dir": flow["u_inf_direction"], "wake_shape_generator": "HelicoidalWake",
        "wake_shape_generator_input": {**flow, "dt": DT, "rotation_velocity": [0.0, 0.0, OMEGA]},
    }  # fmt: skip
    same = {"print_info": False, "dt": DT}
    file["DynamicCoupled"] = {
        "structural_solver": "NonLinearDynamicPrescribedStep", "aero_solver": "StepUvlm",
        "structural_solver_settings": {**same, "newmark_damp": 0.5, "num_steps": TURNS * STEPS,
                                       "max_iterations": 200, "min_delta": 1e-6},
        "aero_solver_settings": {
            **same, "n_time_steps": TURNS * STEPS, "cfl1": False, "convection_scheme": 3,
            "num_cores": 1, "vortex_radius_wake_ind": 1.0, "velocity_field_input": flow},
        "n_time_steps": TURNS * STEPS, "dt": DT, "relaxation_factor": 0.1, "fsi_substeps": 1,
        "correct_forces_method": "PolarCorrection",
        "correct_forces_settings": {"correct_lift": True, "moment_from_polar": True},
    }  # fmt: skip
    file.write()
    return file.filename


with tempfile.TemporaryDirectory() as name:
    root = write(Path(sys.argv[1]), Path(name))
    beam = (data := sharpy.sharpy_main.main(["", settings(Path(name))])).structure
for step in beam.timestep_info[STEPS::STEPS]:
    force, moment = np.zeros(3), np.zeros(3)
    for node, load in enumerate(step.steady_applied_forces):
        element, local = beam.node_master_elem[node]
        turn = algebra.crv2rotation(step.psi[element, local])
        force += turn @ load[:3]
        moment += turn @ load[3:] + np.cross(step.pos[node], turn @ load[:3])
    _, edge, flap = root.T @ (step.pos - beam.ini_info.pos)[2 * ELEMENTS]
    power, thrust = 1e-3 * moment[2] * OMEGA, 1e-3 * force[2]
    print(f"{power:.0f} kW, {thrust:.0f} kN, flap {flap:.3f} m, edge {edge:.3f} m")
