"""Steady operation of a rotor with rigid blades: speed, pitch, power and thrust over the wind."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from ...dynamics.analysis.recovery import Recording
from ...inputs.case.tables.laws import RotationDrive, WindLaw
from ...inputs.case.tables.schema import Mechanism, mechanism_of
from ...math.arrays import Array
from ...math.laws import lengths_along
from ...math.rotations import matrix_to_vector, vector_to_matrix
from ...mechanism.build import build
from ...mechanism.consistent import consistent_state
from ...package.common.files import write_text
from ...signals.rotor import rotor_values
from .shape import blended
from .stations import line_of
from .tables import Tables
from .windio import UPWIND, Blade, turbine_table

# Blade sections in the wind from a windIO file: strips of the blade, polars by thickness.

ANGLES = np.unique(np.r_[-180.0:181.0:5.0, -30.0:30.5:0.5])  # of polars [deg]
COEFFICIENTS = ("cl", "cd", "cm")
RADIANS = 3.5  # largest angle of a polar in radians


@dataclass(frozen=True)
class Strip:
    """A part of a blade about the place `at`, a fraction of the length of its line."""

    name: str
    at: float
    r: float  # [-] of the file
    width: float  # [m]
    chord: float  # [m]
    twist_deg: float  # about the line to the tip, from body y
    offset: float  # [m] aerodynamic centre ahead of the reference axis
    polar: Array  # (n, 3) lift, drag, moment at ANGLES


def strips(
    blade: Blade, tables: Tables, top: Mapping[str, Any], line: Array, n: int
) -> list[Strip]:
    """Return n strips from root to tip, narrower towards the tip.

    Parameters
    ----------
    line : (k, 3) points of the reference axis at equal steps of r from 0 to 1 [m]

    Raises
    ------
    InputError : an airfoil without polars.
    """
    s, r = lengths_along(line), np.linspace(0.0, 1.0, len(line))
    x = np.linspace(0.0, 1.0, n + 1)
    ends = s[-1] * 0.5 * (x + np.sin(0.5 * np.pi * x))
    polars = {airfoil.name: _polar(tables, top, airfoil.name) for airfoil in blade.airfoils}
    rows = []
    for k in range(n):
        at = 0.5 * (ends[k] + ends[k + 1])
        place = float(np.interp(at, s, r))
        row = blended(blade, place, lambda one: polars[one.name])
        centre, polar = float(row[0]), row[1:].reshape(-1, len(COEFFICIENTS))
        chord = blade.chord.at(place)
        rows.append(
            Strip(
                name=f"a{k + 1:02d}",
                at=float(at / s[-1]),
                r=place,
                width=float(ends[k + 1] - ends[k]),
                chord=chord,
                twist_deg=-blade.twist.at(place),
                offset=blade.offset.at(place) - centre * chord,
                polar=polar,
            )
        )
    return rows


def _polar(tables: Tables, top: Mapping[str, Any], name: str) -> Array:
    """Return the aerodynamic centre and the coefficients of an airfoil at ANGLES, flat."""
    entries = tables.entries(top, "airfoils", required=True)
    entry = next(e for e in entries if e.get("name") == name)
    path = f"airfoils.{name}"
    centre = 0.25
    if entry.get("aerodynamic_center") is not None:
        (centre,) = tables.numbers(entry, f"{path}.aerodynamic_center", 1)
    polars = tables.entries(entry, f"{path}.polars", required=True)
    if not polars:
        raise tables.error(f"{path}.polars", "none; expected lift, drag and moment over the angle")
    sets = tables.entries(polars[0], f"{path}.polars[0].re_sets", required=True)
    if not sets:
        raise tables.error(f"{path}.polars[0].re_sets", "none; expected a Reynolds number")
    columns = []
    for key in COEFFICIENTS:
        where = f"{path}.polars[0].re_sets[0].{key}"
        curve = tables.table(sets[0], where)
        grid, values = (tables.numbers(curve, f"{where}.{part}") for part in ("grid", "values"))
        if len(grid) != len(values) or (np.diff(grid) <= 0.0).any():
            raise tables.error(where, "expected rising angles and as many values")
        angles = np.degrees(grid) if np.abs(grid).max() < RADIANS else grid
        if angles[0] > -179.0 or angles[-1] < 179.0:
            message = f"{angles[0]:g} to {angles[-1]:g} deg; expected -180 to 180"
            raise tables.error(f"{where}.grid", message)
        columns.append(PchipInterpolator(angles, values)(np.clip(ANGLES, angles[0], angles[-1])))
    return np.concatenate([[centre], np.column_stack(columns).ravel()])


def section_csv(strips: list[Strip]) -> str:
    """Return the file `table` of a rotor."""
    rows = ["place,chord,width,offset,twist_deg,polar"]
    for one in strips:
        numbers = (one.chord, one.width, one.offset, one.twist_deg)
        rows.append(",".join([one.name, *(f"{value:.8g}" for value in numbers), one.name]))
    return "\n".join([*rows, ""])


def polar_csv(strips: list[Strip]) -> str:
    """Return the file `polar_table` of a rotor."""
    rows = ["polar,alpha_deg,cl,cd,cm"]
    for one in strips:
        for angle, values in zip(ANGLES, one.polar, strict=True):
            rows.append(",".join([one.name, f"{angle:g}", *(f"{value:.6g}" for value in values)]))
    return "\n".join([*rows, ""])


STEP = 0.2  # [deg] of pitch, by which the change of the torque is found
STEEPEST = 45.0  # [deg] largest pitch that is looked for
RPM = math.pi / 30.0
MARGIN = 1.1  # by which the largest torque of a reference controller is above that at rated power
STRIPS = 20  # of a blade
WINDS = (4.0, 5.0, 7.0, 8.0, 9.0, 10.0, 11.0, 13.0, 15.0, 17.0, 21.0, 25.0)  # [m/s]
DENSE = 2001  # points along the line of a blade
AERO, POLARS, OPERATION = "aero.csv", "polars.csv", "operation.csv"


@dataclass(frozen=True)
class Turbine:
    """What the operation of a rotor needs: blades, speeds [rad/s], torque at the shaft [N m].

    ratio : of the speed of tips and wind, below rated power
    """

    blades: int
    slowest: float
    rated: float
    rated_torque: float
    ratio: float
    fine_pitch: Array  # (2, n) least pitch [deg] in the second row over wind speeds


def read_turbine(tables: Tables, top: Mapping[str, Any]) -> Turbine:
    """Read assembly and control of a windIO file; `min_pitch_table` goes over `fine_pitch`.

    Raises
    ------
    InputError : a key is missing or wrong; a downwind rotor.
    """
    assembly = tables.table(top, "assembly")
    side = str(assembly.get("rotor_orientation") or UPWIND).lower()
    if side != UPWIND:
        raise tables.error("assembly.rotor_orientation", f"{side!r}; expected 'upwind'")

    def number(parent: Mapping[str, Any], path: str, default: float | None = None) -> float:
        if default is not None and parent.get(path.rpartition(".")[2]) is None:
            return default
        return float(tables.numbers(parent, path, 1)[0])

    control = tables.table(top, "control")
    drive = tables.table(top, "components").get("drivetrain")
    gear = (drive.get("gearbox") if isinstance(drive, dict) else None) or {}
    rated = RPM * number(control, "control.rated_rotor_speed")
    torque = number(assembly, "assembly.rated_power") / rated
    largest = number(control, "control.max_gen_torque", 0.0) / MARGIN
    largest *= number(gear, "components.drivetrain.gearbox.gear_ratio", 1.0)
    for unit in (1.0, 1e3):  # files give N m or kN m, at the generator
        if 1.0 <= largest * unit / torque < 1.15:  # with the losses of the generator
            torque = largest * unit
            break
    fine = np.array([[0.0], [number(control, "control.fine_pitch", 0.0)]])
    if control.get("min_pitch_table") is not None:
        path = "control.min_pitch_table"
        given = tables.table(control, path)
        winds, least = (tables.numbers(given, f"{path}.{k}") for k in ("wind_speed", "min_pitch"))
        if len(winds) != len(least) or (np.diff(winds) <= 0.0).any():
            raise tables.error(path, "expected rising wind_speed and as many min_pitch")
        fine = np.array([winds, least])
    return Turbine(
        blades=int(number(assembly, "assembly.number_of_blades", 3.0)),
        slowest=RPM * number(control, "control.min_rotor_speed", 0.0),
        rated=rated,
        rated_torque=torque,
        ratio=number(control, "control.optimal_tsr"),
        fine_pitch=fine,
    )


@dataclass(frozen=True)
class Point:
    """One wind speed: speed of the rotor [rad/s], pitch [deg], torque [N m], thrust [N].

    fine : the least pitch [deg]
    """

    wind: float
    speed: float
    pitch: float
    torque: float
    thrust: float
    fine: float


class RigidRotor:
    """The strips of blades on rigid bodies that turn about x, to the wind, at a steady speed.

    Parameters
    ----------
    places : (n, 3) of the strips in the axes of a blade [m]
    root : radius of the root [m]; cone_deg : of the blades
    """

    def __init__(
        self,
        strips: Sequence[Strip],
        places: Array,
        root: float,
        cone_deg: float,
        turbine: Turbine,
        folder: Path,
    ) -> None:
        self.turbine, n = turbine, turbine.blades
        self.axes = {f"blade-{i + 1}": blade_axes(i, n, cone_deg) for i in range(n)}
        self.blades = list(self.axes)
        self.mechanism = self._read([s.name for s in strips], places, root, folder)
        self.loads = lru_cache(maxsize=None)(self._loads)
        cosine = math.cos(math.radians(cone_deg))
        self.radius = cosine * (root + float(places[-1, 0]) + 0.5 * strips[-1].width)

    def _loads(self, wind: float, speed: float, pitch: float) -> tuple[float, float]:
        """Return torque [N m] and thrust [N]; pitch [deg]."""
        mechanism, bodies = self.mechanism, dict(self.mechanism.bodies)
        for name in self.blades:
            turned = self.axes[name] @ vector_to_matrix(np.array([-math.radians(pitch), 0.0, 0.0]))
            rotation = np.degrees(matrix_to_vector(turned)).tolist()
            bodies[name] = bodies[name].model_copy(update={"rotation_deg": rotation})
        shaft = mechanism.joints["shaft"]
        drive = RotationDrive(speed=speed)
        rotor = mechanism.rotor
        assert rotor is not None
        blowing = rotor.wind.model_copy(update={"speed": WindLaw(constant=wind)})
        update = {
            "bodies": bodies,
            "joints": {**mechanism.joints, "shaft": shaft.model_copy(update={"drive": drive})},
            "rotor": rotor.model_copy(update={"wind": blowing}),
        }
        built = build(mechanism.model_copy(update=update), {})
        y = consistent_state(built.model, built.start, built.joint_names)
        recording = Recording(built.model, np.zeros(1), y[None])
        torque, thrust = (rotor_values(built, q)(recording)[0] for q in ("moment", "thrust"))
        return float(torque), float(thrust)

    def by_pitch(self, point: Point) -> float:
        """Return the change of the torque by pitch at an operating point [N m/rad]."""
        up, down = (self.loads(point.wind, point.speed, point.pitch + d)[0] for d in (STEP, -STEP))
        return (up - down) / math.radians(2.0 * STEP)

    def best(self) -> float:
        """Return the torque over the square of the speed at the best ratio of tip and wind speed.

        [N m s2]
        """
        t = self.turbine
        speed = max(0.8 * t.rated, t.slowest)
        wind = speed * self.radius / t.ratio
        return self.loads(wind, speed, fine_pitch(t, wind))[0] / speed**2

    def _read(self, strips: Sequence[str], places: Array, root: float, folder: Path) -> Mechanism:
        """Return the mechanism at 1 rad/s, with the blades at a pitch of zero."""
        hub: dict[str, Any] = {"kind": "rigid", "mass": 1.0, "inertia": np.eye(3).tolist()}
        hub["interfaces"] = {"centre": {"position": [0.0] * 3}}
        shaft = {
            "kind": "revolute",
            "between": ["ground.o", "hub.centre"],
            "axis": [1.0, 0.0, 0.0],
            "drive": {"speed": 1.0},
        }
        table: dict[str, Any] = {
            "bodies": {"hub": hub},
            "ground": {"o": {"position": [0.0] * 3}},
            "joints": {"shaft": shaft},
            "solver": {"t_end": 1.0, "output_step": 1.0},
        }
        points = {n: {"position": p} for n, p in zip(strips, places.tolist(), strict=True)}
        for name, A in self.axes.items():
            at = (root * A[:, 0]).tolist()
            table["bodies"][name] = {
                "kind": "rigid", "mass": 1.0, "inertia": np.eye(3).tolist(), "position": at,
                "rotation_deg": np.degrees(matrix_to_vector(A)).tolist(),
                "interfaces": {"root": {"position": [0.0] * 3}, **points},
            }  # fmt: skip
            hub["interfaces"][name] = {"position": at}
            ends = [f"hub.{name}", f"{name}.root"]
            table["joints"][name] = {"kind": "fixed", "between": ends}
        table["rotor"] = {
            "hub": "hub.centre", "axis": [1.0, 0.0, 0.0], "blades": self.blades, "table": AERO,
            "polar_table": POLARS, "induction": "madsen", "wind": {"speed": {"constant": 10.0}},
        }  # fmt: skip
        return mechanism_of(table, folder)[0]


def blade_axes(i: int, blades: int, cone_deg: float) -> Array:
    """Return the axes (3, 3) of blade i of an upwind rotor, in columns.

    The wind is along x, z upwards, the first blade upright; the rotor turns about the wind.

    Parameters
    ----------
    i : number of the blade, from 0
    blades : number of blades
    cone_deg : cone angle [deg]
    """
    c, s = math.cos(math.radians(cone_deg)), math.sin(math.radians(cone_deg))
    upright = np.array([[-s, 0.0, c], [0.0, -1.0, 0.0], [c, 0.0, s]])
    turn = vector_to_matrix(np.array([2.0 * math.pi * i / blades, 0.0, 0.0]))
    return np.asarray(turn @ upright)


def operation(rotor: RigidRotor, winds: Sequence[float]) -> list[Point]:
    """Return the operating points at wind speeds [m/s].

    At the best speed of the tips up to the rated speed; then at the rated torque by pitch.
    """
    t, points = rotor.turbine, []
    for wind in winds:
        speed = min(max(t.ratio * wind / rotor.radius, t.slowest), t.rated)
        fine = pitch = fine_pitch(t, wind)
        if rotor.loads(wind, speed, pitch)[0] > t.rated_torque:
            speed, pitch = t.rated, _pitch(rotor, wind)
        points.append(Point(wind, speed, pitch, *rotor.loads(wind, speed, pitch), fine))
    return points


def fine_pitch(turbine: Turbine, wind: float) -> float:
    """Return the least pitch [deg] at a wind speed [m/s]."""
    return float(np.interp(wind, *turbine.fine_pitch))


def _pitch(rotor: RigidRotor, wind: float) -> float:
    """Return the pitch to feather with rated torque at rated speed [deg]."""
    t = rotor.turbine

    def excess(pitch: float) -> float:
        return rotor.loads(wind, t.rated, pitch)[0] - t.rated_torque

    fine = fine_pitch(t, wind)
    return fine if excess(fine) <= 0.0 else float(brentq(excess, fine, STEEPEST, xtol=1e-4))


def operation_csv(points: Sequence[Point]) -> str:
    """Return the table of operating points."""
    rows = ["wind_m_s,speed_rpm,pitch_deg,power_kw,thrust_kn,torque_knm"]
    for p in points:
        power, rpm = p.torque * p.speed, 30.0 * p.speed / math.pi
        values = (p.wind, rpm, p.pitch, power / 1e3, p.thrust / 1e3, p.torque / 1e3)
        rows.append(",".join(f"{value:.6g}" for value in values))
    return "\n".join([*rows, ""])


def read_rotor(blade: Blade) -> tuple[Turbine, list[Strip], Array]:
    """Return what the file has of its rotor, its strips and their places (n, 3) [m].

    Raises
    ------
    InputError : the file lacks polars, or numbers of the turbine.
    """
    tables, top = Tables(blade.file), turbine_table(blade.file)
    turbine, r = read_turbine(tables, top), np.linspace(0.0, 1.0, DENSE)
    line = line_of(blade, r.tolist())
    blade_strips = strips(blade, tables, top, line, STRIPS)
    at = [s.r for s in blade_strips]
    return turbine, blade_strips, np.column_stack([np.interp(at, r, column) for column in line.T])


def write_rotor(
    blade: Blade, folder: Path
) -> tuple[list[Path], list[Strip], RigidRotor, list[Point]]:
    """Write strips and polars of a blade in the wind, and its steady operation.

    Returns the files, strips, rotor and operating points. Raises as `read_rotor`.
    """
    turbine, blade_strips, places = read_rotor(blade)
    write_text(folder / AERO, section_csv(blade_strips))
    write_text(folder / POLARS, polar_csv(blade_strips))
    hub = blade.hub
    rotor = RigidRotor(blade_strips, places, hub.radius, hub.cone_deg, turbine, folder)
    points = operation(rotor, WINDS)
    write_text(folder / OPERATION, operation_csv(points))
    return [folder / name for name in (AERO, POLARS, OPERATION)], blade_strips, rotor, points
