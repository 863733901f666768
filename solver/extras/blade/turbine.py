"""The case of a turbine from a windIO file: flexible blades, hub, nacelle, tower, a controller."""

import math
import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import printable
from ...inputs.case.record import CASE_FILE
from ...inputs.case.tables.beam_keys import COLUMNS, UPPER
from ...math.arrays import Array
from ...math.rotations import matrix_to_vector, vector_to_matrix
from ...package.common.files import write_text
from ...package.common.plain_data import toml_value
from .materials import Materials
from .operation import DENSE, Point, RigidRotor, Strip, Turbine, blade_axes
from .stations import Station, complete, elements_of, line_of
from .tables import Table, Tables
from .windio import Blade, turbine_table

ROTOR_CASE, TOWER = "rotor.toml", "tower.csv"
MODES_ALONE = 10  # vibrations of a blade in a case of its own
TIP_SPEED = 80.0  # [m/s] of its run
MODES = 4  # lowest vibrations of a clamped blade, beside the static shapes
TEMPLATES = Path(__file__).with_name("turbine_case.txt")
BLADED, BLADED_TEXT = "bladed.py", Path(__file__).with_name("bladed.txt")
SAMPLE = 0.05  # [s] between calls of a controller with the interface of Bladed
FLAT = 5.0  # [deg] above the least pitch, where the change of the torque by pitch is not used
BEARING = 2.0 * math.pi * 10.0  # [rad/s] of a blade on its pitch drive

ERROR = "gain(state('pitch')) * (state('measured') - rated_speed)"
FREE = f"state('integral') + 2 * w * {ERROR}"
DEMAND = f"clip({FREE}, fine_pitch, 1.57)"


def write_blade_case(blade: Blade, stations: Sequence[Station], folder: Path) -> Path:
    """Write the case of a blade whose table beam.csv is in `folder`; returns its file.

    Parameters
    ----------
    blade : blade of the windIO file
    stations : analysed stations
    folder : folder with beam.csv
    """
    count = len(complete(stations))
    radius, cone = blade.hub.radius, blade.hub.cone_deg
    angle = math.radians(cone)
    length = float(blade.length.values[-1] - blade.length.values[0])
    speed = TIP_SPEED / (radius + length)
    file = folder / CASE_FILE
    text = parts()["ALONE"].format(
        file_name=printable(blade.file.name),
        title=toml_value(f"Blade of {blade.file.name}"),
        file=printable(shlex.quote(str(file))),
        speed=speed,
        step=speed / 8.0,
        tip=TIP_SPEED,
        stations=count,
        root=[radius * math.cos(angle), 0.0, -radius * math.sin(angle) + 0.0],
        elements=elements_of(count),
        modes=MODES_ALONE,
        radius=radius,
        cone=cone,
    )
    write_text(file, f"{text}\n")
    return file


class Machine:
    """What a windIO file has of a turbine besides its blades.

    `centre` of the rotor [m]; `turn`: matrix of the tilt; `limit` of the rate of the pitch and
    frequency of the `actuator` [rad/s]; `own`: numbers of the hub; `below`: text of the case below
    the rotor; `tower`: its table, empty if there is none.

    Raises
    ------
    InputError : the file lacks numbers of the hub, of the nacelle or of the tower.
    """

    def __init__(self, blade: Blade, t: Turbine) -> None:
        tables, top = Tables(blade.file), turbine_table(blade.file)
        components, control = (tables.table(top, key) for key in ("components", "control"))

        def number(parent: Mapping[str, Any], path: str, default: float | None = None) -> float:
            if default is not None and parent.get(path.rpartition(".")[2]) is None:
                return default
            return float(tables.numbers(parent, path, 1)[0])

        drive = components.get("drivetrain") or {}
        outer = drive.get("outer_shape") or {}
        path = "components.drivetrain"
        self.tilt = number(outer, f"{path}.outer_shape.uptilt", 0.0)
        self.height = number(tables.table(top, "assembly"), "assembly.hub_height")
        overhang = number(outer, f"{path}.outer_shape.overhang", 0.0)
        self.centre = np.array([-overhang, 0.0, self.height])
        self.turn = vector_to_matrix(np.array([0.0, math.radians(self.tilt), 0.0]))
        self.ratio = float((drive.get("gearbox") or {}).get("gear_ratio") or 1.0)
        self.own = _hub(tables, components, drive, self.ratio)
        rate = number(control, "control.max_pitch_rate", math.degrees(0.1 * t.rated))
        self.limit = math.radians(rate)
        self.actuator = number(control, "control.pitch_actuator_frequency", 4.0 * t.rated)
        self.tower, self.below = "", parts()["ON_GROUND"].format(hub=_list(self.centre))
        if "tower" not in components:
            return
        foot, self.tower = _tower(tables, components["tower"], Materials(tables, top))
        tt = self.height - number(outer, f"{path}.outer_shape.distance_tt_hub")
        nacelle = tables.table(drive, f"{path}.elastic_properties")
        where = f"{path}.elastic_properties"
        self.below = parts()["ON_TOWER"].format(
            foot=_list(foot),
            top=_list([0.0, 0.0, tt]),
            shaft=_list(self.centre - [0.0, 0.0, tt]),
            mass=number(nacelle, f"{where}.mass"),
            centre=_list(tables.numbers(nacelle, f"{where}.location", 3)),
            inertia=_symmetric(tables.numbers(nacelle, f"{where}.inertia", 6)),
        )


def parts() -> dict[str, str]:
    """Return the parts of the template of a case by name."""
    text = TEMPLATES.read_text("utf-8")
    return dict(re.findall(r"%% (\w+)\n(.*?)(?=\n%% |\Z)", text, re.DOTALL))


def write_turbine(
    blade: Blade,
    stations: Sequence[Station],
    strips: Sequence[Strip],
    rotor: RigidRotor,
    points: Sequence[Point],
    folder: Path,
    controller: Sequence[Path] = (),
) -> list[Path]:
    """Write the case of a turbine, and the table of its tower; returns the files.

    Parameters
    ----------
    points : steady operation over the wind
    controller : a library with the interface of Bladed, and its input file; else our own

    Raises InputError as `Machine`.
    """
    t, machine, part = rotor.turbine, Machine(blade, rotor.turbine), parts()
    own, centre, turn = machine.own, machine.centre, machine.turn
    n = turn[:, 0]
    J_pitch, J_blade = _inertia(blade, stations)
    inertia = own["hub_inertia"][0][0] + t.blades * J_blade
    # Near the rated wind the torque changes little by pitch, but flexible blades turn further.
    pitched = [p for p in points if p.pitch > p.fine + 0.1]
    pitched = [p for p in pitched if p.pitch > p.fine + FLAT] or pitched
    gained = sorted((math.radians(p.pitch), -inertia / rotor.by_pitch(p)) for p in pitched)
    w = 0.25 * t.rated
    # Between the least and the rated speed, where the law of the generator is best * v^2.
    steady = min(points, key=lambda p: abs(p.speed - 0.85 * t.rated))
    step = next((p for p in points if p.pitch > p.fine + 0.1), points[-1])
    files = [folder / ROTOR_CASE]
    if machine.tower:
        write_text(folder / TOWER, machine.tower)
        files.append(folder / TOWER)
    own_law = not controller
    text = "".join(part[k] for k in ("HEAD", "CONTROL" if own_law else "BLADED", "HUB")).format(
        bladed=BLADED, sample=SAMPLE, start_torque=steady.torque,
        name=blade.file.name, file=ROTOR_CASE, title=toml_value(f"{blade.file.stem} in the wind"),
        wind=steady.wind, speed=steady.speed, pitch=steady.pitch, fine=math.radians(steady.fine),
        rated=t.rated, slowest=t.slowest or 0.2 * t.rated, torque=t.rated_torque,
        best=rotor.best(), w=w, low_pass=20.0 * w,
        limit=machine.limit, axis=_list(n), blades=toml_value(rotor.blades), height=machine.height,
        pitches=_list([p for p, _ in gained]), gains=_list([g for _, g in gained]),
        error=ERROR, free=FREE, demand=DEMAND,
        actuator=machine.actuator, shaft='"nacelle.shaft"' if machine.tower else '"ground.hub"',
        hub=_list(centre), tilt=machine.tilt, **{**own, "hub_inertia": _rows(own["hub_inertia"])},
    )  # fmt: skip
    blades, roots = [], ""
    # The lowest vibrations hardly twist a blade: without these shapes the tips lack 0.04 rad.
    twisted = [strips[len(strips) // 2 - 1].name, strips[3 * len(strips) // 4 - 1].name]
    loaded = [("tip", ["z", "rx"]), *((name, ["rx"]) for name in twisted)]
    shapes = [{"kind": "attachment", "at": at, "directions": list(d)} for at, d in loaded]
    k = J_pitch * BEARING**2
    if controller:
        library, given = (str(file.resolve()) for file in controller)
        program = BLADED_TEXT.read_text("utf-8").format(
            library=library, input=given, sample=SAMPLE, blades=t.blades, ratio=machine.ratio, k=k
        )
        write_text(folder / BLADED, program)
        files.append(folder / BLADED)
    places = ", ".join(f"{s.name} = {{ at = {s.at:.8g} }}" for s in strips)
    for i, name in enumerate(rotor.blades):
        local = blade_axes(i, t.blades, blade.hub.cone_deg)
        root = blade.hub.radius * local[:, 0]
        roots += f"{name} = {{ position = {_list(root)} }}\n"
        A = turn @ local
        x, y, z = A.T @ n
        c, s = "cos(pitch_deg*pi/180)", "sin(pitch_deg*pi/180)"
        spin = [f"speed * {x:.15g}", f"speed * ({y:.15g}*{c} - ({z:.15g})*{s})",
                f"speed * ({y:.15g}*{s} + ({z:.15g})*{c})"]  # fmt: skip
        blades.append(
            part["BLADE"].format(
                name=name, i=i + 1, elements=elements_of(len(complete(stations))), modes=MODES,
                shapes=toml_value(shapes)[1:-1],
                root=_list(centre + turn @ root), spin=toml_value(spin), places=places,
                rotation=_list(np.degrees(matrix_to_vector(A))), axis=_list(-A[:, 0]), k=k,
                c=1.4 * k / BEARING, asked="state('pitch')" if own_law else "pitch_deg * pi / 180",
            )
        )  # fmt: skip
        blades += [] if own_law else [part["DEMAND"].format(i=i + 1, bladed=BLADED, sample=SAMPLE)]
    tail = part["TAIL"].format(
        wind=steady.wind, step=step.wind, step_speed=step.speed,
        step_pitch=step.pitch, step_fine=math.radians(step.fine), step_torque=step.torque,
        torque="generator" if own_law else "control", torques=_list([p.torque for p in points]),
        winds=_list([p.wind for p in points]), speeds=_list([p.speed for p in points]),
        pitches=_list([p.pitch for p in points]),
        fines=_list([math.radians(p.fine) for p in points]),
    )  # fmt: skip
    write_text(folder / ROTOR_CASE, "\n".join([f"{text}\n{roots}", *blades, machine.below, tail]))
    return files


def _list(values: Any) -> str:
    return "[" + ", ".join(f"{float(v) + 0.0:.15g}" for v in values) + "]"


def _rows(matrix: Any) -> str:
    return "[" + ", ".join(_list(row) for row in matrix) + "]"


def _symmetric(six: Array) -> str:
    xx, yy, zz, xy, xz, yz = six
    return _rows([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _hub(
    tables: Tables, components: Mapping[str, Any], drive: Mapping[str, Any], ratio: float
) -> Table:
    """Return mass, centre and inertia of the hub, with the rotating inertia of the generator."""
    path = "components.hub.elastic_properties"
    given = tables.table(tables.table(components, "components.hub"), path)
    mass = float(tables.numbers(given, f"{path}.mass", 1)[0])
    centre = 0.0
    if given.get("location") is not None:
        centre = float(tables.numbers(given, f"{path}.location", 3)[0])
    inertia = np.diag(tables.numbers(given, f"{path}.inertia")[:3])
    machine = (drive.get("generator") or {}).get("elastic_properties")
    if machine:
        where = "components.drivetrain.generator.elastic_properties.inertia"
        turning = ratio**2 * tables.numbers(machine, where)[0]
        inertia += turning * np.diag([1.0, 0.5, 0.5])  # a disc
    return {"hub_mass": mass, "hub_centre": centre, "hub_inertia": inertia.tolist()}


def _inertia(blade: Blade, stations: Sequence[Station]) -> tuple[float, float]:
    """Return the moments of inertia of a blade about its pitch axis and about the shaft [kg m2]."""
    known = [(s.r, s.results.M) for s in stations if s.results is not None]
    r = np.linspace(0.0, 1.0, DENSE)
    line = line_of(blade, r.tolist())
    mass, own = (np.interp(r, [at for at, _ in known], [M[i, i] for _, M in known]) for i in (0, 3))
    along = np.gradient(np.linalg.norm(np.diff(line, axis=0, prepend=line[:1]), axis=1).cumsum())
    off = line[:, 1] ** 2 + line[:, 2] ** 2
    reach = (blade.hub.radius + line[:, 0]) * math.cos(math.radians(blade.hub.cone_deg))
    about_pitch, about_shaft = (own + mass * off) * along, mass * reach**2 * along
    return float(about_pitch.sum()), float(about_shaft.sum())


def _tower(tables: Tables, tower: Mapping[str, Any], materials: Materials) -> tuple[Array, str]:
    """Return the foot of a tower and its table: a tube of one material."""
    path = "components.tower"
    axis = tables.table(tables.table(tower, f"{path}.reference_axis"), f"{path}.reference_axis.z")
    grid, z = (tables.numbers(axis, f"{path}.reference_axis.z.{key}") for key in ("grid", "values"))
    shape = tables.table(tower, f"{path}.outer_shape")
    diameter = tables.along(shape, f"{path}.outer_shape.outer_diameter")
    structure = tables.table(tower, f"{path}.structure")
    layers = tables.entries(structure, f"{path}.structure.layers", required=True)
    if len(layers) != 1:
        raise tables.error(f"{path}.structure.layers", f"{len(layers)}; expected one")
    where = f"{path}.structure.layers[0]"
    wall = tables.along(layers[0], f"{where}.thickness")
    name = tables.text(layers[0], f"{where}.material")
    material = materials.read({name}).get(name, {})
    if "E" not in material:
        raise tables.error(f"{where}.material", f"{name}; expected an isotropic one of `materials`")
    E, rho, nu = (material[key] for key in ("E", "rho", "nu"))
    factor = float(structure.get("outfitting_factor") or 1.0)
    rows = [",".join(COLUMNS)]
    for at, height in zip(grid, z, strict=True):
        d, h = diameter.at(float(at)), wall.at(float(at))
        area = math.pi * h * (d - h)
        second = area * ((d - h) ** 2 + h**2) / 8.0
        G, density = E / (2.0 * (1.0 + nu)), factor * rho
        K = np.diag([E * area, *[0.5 * G * area] * 2, 2.0 * G * second, *[E * second] * 2])
        M = np.diag([*[density * area] * 3, 2.0 * density * second, *[density * second] * 2])
        numbers = [height - z[0], 0.0, 0.0, 0.0, *(A[i, j] for A in (K, M) for i, j in UPPER)]
        rows.append(",".join(repr(float(value)) for value in numbers))
    return np.array([0.0, 0.0, z[0]]), "\n".join([*rows, ""])
