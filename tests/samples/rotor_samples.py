"""A small rotor of three rigid blades in the wind, as a case and for a second method."""

from pathlib import Path
from typing import Any

import numpy as np

HUB, TIP, STRIPS, RPM = 1.0, 20.0, 16, 40.0
ANGLES = np.unique(np.r_[-180.0:181.0:5.0, -30.0:31.0:1.0])


def stations() -> dict[str, np.ndarray]:
    """Radius, width, chord [m] and twist [deg], positive to feather, of the strips."""
    x = np.linspace(0.0, 1.0, STRIPS + 1)
    ends = HUB + (TIP - HUB) * 0.5 * (x + np.sin(0.5 * np.pi * x))
    r = 0.5 * (ends[1:] + ends[:-1])
    share = (r - HUB) / (TIP - HUB)
    return {"r": r, "width": np.diff(ends), "chord": 2.0 - 1.4 * share,
            "twist": 14.0 * (1.0 - share) ** 2}  # fmt: skip


def polar() -> np.ndarray:
    """Lift, drag, moment (n, 3) at ANGLES: 2 pi (alpha + 3 deg), stalled beyond 12 deg."""
    a = np.radians(ANGLES)
    stalled = 1.0 / (1.0 + np.exp((np.abs(a) - np.radians(14.0)) / np.radians(1.5)))
    lift = 2.0 * np.pi * np.sin(a + np.radians(3.0)) * stalled
    lift += (1.0 - stalled) * 1.1 * np.sin(2.0 * a)
    drag = 0.008 + (1.0 - stalled) * 1.3 * np.sin(a) ** 2
    return np.column_stack([lift, drag, -0.05 * stalled])


def write_rotor(
    folder: Path,
    wind: str = "speed = { constant = 10.0 }",
    *,
    pitch: float = 0.0,
    tilt: tuple[float, float] = (0.0, 0.0),
    free: bool = False,
    induction: str = "buhl",
    solver: str = "t_end = 1.0\noutput_step = 0.1",
    polar_name: str = "thin",
) -> Path:
    """Write a case with its tables.

    Parameters
    ----------
    pitch : of the blades [deg]
    tilt : angles of the shaft about y and z [deg]
    free : a moment of inertia in place of a steady speed
    """
    from scipy.spatial.transform import Rotation

    s = stations()
    rows = ["place,chord,width,offset,twist_deg,polar"]
    columns = [s["chord"], s["width"], 0.0 * s["r"], -s["twist"]]
    for k, row in enumerate(np.column_stack(columns).tolist()):
        rows.append(",".join([f"a{k}", *map(repr, row), polar_name]))
    (folder / "aero.csv").write_text("\n".join(rows))
    rows = ["polar,alpha_deg,cl,cd,cm"]
    rows += [f"thin,{a:g},{c[0]!r},{c[1]!r},{c[2]!r}" for a, c in
             zip(ANGLES.tolist(), polar().tolist(), strict=True)]  # fmt: skip
    (folder / "polars.csv").write_text("\n".join(rows))
    whole = Rotation.from_euler("yz", tilt, degrees=True)
    axis = whole.apply([1.0, 0.0, 0.0]).tolist()
    bodies, joints = "", ""
    places = ", ".join(f"a{k} = {{ position = [{r!r}, 0.0, 0.0] }}" for k, r in
                       enumerate(s["r"].tolist()))  # fmt: skip
    for i in range(3):
        blade = Rotation.from_matrix([[0, 0, 1], [0, -1, 0], [1, 0, 0]])
        feathered = blade * Rotation.from_euler("x", -pitch, degrees=True)
        turned = whole * Rotation.from_euler("x", 120.0 * i, degrees=True) * feathered
        vector = turned.as_rotvec(degrees=True).tolist()
        bodies += (
            f'[bodies.b{i}]\nkind = "rigid"\nmass = 100.0\nrotation_deg = {vector}\n'
            "inertia = [[10.0, 0.0, 0.0], [0.0, 9000.0, 0.0], [0.0, 0.0, 9000.0]]\n"
            f"interfaces = {{ root = {{ position = [0.0, 0.0, 0.0] }}, {places} }}\n"
        )
        joints += f'[joints.f{i}]\nkind = "fixed"\nbetween = ["hub.centre", "b{i}.root"]\n'
    speed = RPM * np.pi / 30.0
    drive = f"drive = {{ speed = {speed!r} }}"
    spin = [speed * x for x in axis]
    text = f"""format = 1
title = "rotor"
[bodies.hub]
kind = "rigid"
mass = 1000.0
inertia = [[2e5, 0.0, 0.0], [0.0, 2e5, 0.0], [0.0, 0.0, 2e5]]
interfaces = {{ centre = {{ position = [0.0, 0.0, 0.0] }} }}
{f"angular_velocity = {spin}" if free else ""}
{bodies}
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.shaft]
kind = "revolute"
between = ["ground.o", "hub.centre"]
axis = {axis}
{"" if free else drive}
{joints}
[rotor]
hub = "hub.centre"
axis = {axis}
blades = ["b0", "b1", "b2"]
table = "aero.csv"
polar_table = "polars.csv"
induction = "{induction}"
[rotor.wind]
{wind}
[signals.thrust]
kind = "rotor"
quantity = "thrust"
[signals.torque]
kind = "rotor"
quantity = "moment"
[signals.power]
kind = "rotor"
quantity = "power"
[signals.speed]
kind = "angular_velocity"
at = "hub.centre"
component = "x"
[solver]
{solver}
[runs.all]
"""
    file = folder / "case.toml"
    file.write_text(text)
    return file


def ccblade(speed: float, pitch: float) -> dict[str, Any]:
    """Loads of the same rotor by CCBlade of WISDEM: along the shaft and around it [N/m].

    Its splines of the polar smooth by default, by several times its lowest drag; here they do not.
    """
    from scipy.interpolate import RectBivariateSpline
    from wisdem.ccblade.ccblade import CCAirfoil, CCBlade

    s, c = stations(), polar()
    airfoil = CCAirfoil(ANGLES, [1e7], c[:, 0], c[:, 1], c[:, 2])
    for name, values in zip(("cl_spline", "cd_spline"), c.T, strict=False):
        pairs = np.column_stack([values, values])
        spline = RectBivariateSpline(np.radians(ANGLES), [1e1, 1e15], pairs, kx=3, ky=1, s=0.0)
        setattr(airfoil, name, spline)
    rotor = CCBlade(
        s["r"], s["chord"], s["twist"], [airfoil] * STRIPS, HUB, TIP, B=3, rho=1.225,
        precone=0.0, tilt=0.0, yaw=0.0, shearExp=0.0, hubHt=100.0, nSector=1, derivatives=False,
    )  # fmt: skip
    loads, _ = rotor.distributedAeroLoads(speed, RPM, pitch, 0.0)
    return {"axial": loads["Np"].tolist(), "around": loads["Tp"].tolist()}
