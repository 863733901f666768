"""Whether materials and sizes can be meant in SI units: warnings, never errors.

One place of limits for sections, shells, bodies and blades. `material_doubts` takes the tables of
materials of any description. `allow` of a description lists the codes of what is meant.
"""

from collections.abc import Iterable, Iterator, Mapping
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from ...math.arrays import Array

MATERIAL, SIZE, ANGLE = "material-units", "size-units", "angle-units"
CODES = (MATERIAL, SIZE)

# Speed of waves along the stiffest axis, sqrt(E / rho) [m/s]: silicone rubber 20 to 40, soft foam
# 50, cork 500, steel 5000, diamond 18 000, graphene 21 000. With moduli in MPa, plies of carbon
# fibre have up to 15.
SLOWEST, FASTEST = 20.0, 25_000.0
# Density [kg/m3]: polystyrene foam from 10, aerogel 3 to 350 (Ashby, Materials Selection, charts of
# modulus and density); tungsten 19 300, osmium 22 590.
LIGHTEST, HEAVIEST = 3.0, 23_000.0
WITHOUT_UNITS = 1.0  # density of examples in textbooks and manuals whose numbers have no units
# A void is a material without effect beside others, as a part of the stiffest and heaviest.
VOID = 1e-3
# Smallest over largest modulus or strength of one material: honeycomb (in its plane, where walls of
# t / l = 0.01 bend) 1e-4, its strength 1e-4 of that. With some numbers in MPa or GPa 1e-8 and less.
MIXED = 1e-7

# Plies of fibres [m]: spread tows from 1e-5; a layer of a blade's spar cap has up to 0.1.
THINNEST_PLY, THICKEST_PLY = 1e-6, 0.1
FIBRES = 2.0  # E1 over E2 and E3 of a ply with fibres
# Sheet of a metal [m]: vessels of reactors 0.4. Walls of concrete and stone have up to 60 GPa.
METAL, THICKEST_SHEET = 60e9, 0.5
# Size [m] and mass per length [kg/m] of a section: a road bridge has 40 m and 30e3 kg/m, the tower
# and monopile of a wind turbine 10 m and 25e3 kg/m. With mm for m, a bar of 20 by 2 mm has 6e4.
LARGEST_SECTION, HEAVIEST_SECTION = 50.0, 5e4
SMALLEST_SECTION = 1e-7  # beams of microsystems have 1e-6
HEAVIEST_BODY = 1e8  # [kg]: the ship Titanic 5e7. With mm for m, 0.1 kg become 1e8 kg.
# Free fall [m/s2]: the Sun has 274, centrifuges for models of soil 3000; Earth has 9810 mm/s2.
STRONGEST_GRAVITY = 5000.0
# Numbers that are more likely degrees than radians, of which they are 5 to 57 turns.
DEGREES = (30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0, 180.0, 270.0, 360.0)
# Mass over the cube of twice the radius of gyration [kg/m3]: a boom of 20 m and 1 kg has 6e-4, a
# solar sail of 100 kg and 80 m 2e-4. With kg mm2 for kg m2, a steel ball has 1e-5 and others less.
THINNEST_BODY = 1e-4

# Air [kg/m3]: 1.225 at sea level, 0.82 at 4000 m, 1.45 at -30 C; water, of turbines in tides.
AIR, WATER = (0.8, 1.5), (990.0, 1040.0)
# Of turbines [m/s]: tips of the largest have 80 to 110; they stop at 25 to 34, and gusts in which
# they are parked have 70 (IEC 61400-1, class I).
FASTEST_TIP, FASTEST_WIND, CUT_OUT, PARKED = 150.0, 100.0, 35.0, 20.0


class Doubt(NamedTuple):
    """A doubt about numbers of the user; `text` begins with what they belong to."""

    code: str
    text: str
    value: float

    @property
    def warning(self) -> dict[str, str]:
        """The warning of a file."""
        return {"code": self.code, "message": self.text}


def material_doubts(materials: Mapping[str, Any]) -> Iterator[Doubt]:
    """Yield the materials whose constants cannot be those of a material in Pa and kg/m3.

    Parameters
    ----------
    materials : tables of constants by name, of any kind that a specification has
    """
    known = {name: pair for name, m in materials.items() if (pair := _numbers(m)) is not None}
    for name, (modulus, least, density) in known.items():
        if density == WITHOUT_UNITS:
            continue
        if least < MIXED * modulus:
            text = (
                f"material {name} has constants of {modulus:.4g} and {least:.4g} Pa: are all of "
                "them in Pa, none in MPa or GPa?"
            )
            yield Doubt(MATERIAL, text, least / modulus)
        if density == 0.0 or _is_void(name, known):
            continue
        speed = sqrt(modulus / density)
        if not SLOWEST <= speed <= FASTEST:
            text = (
                f"material {name} has E = {modulus:.4g} Pa and rho = {density:.4g} kg/m3, so that "
                f"waves travel along it at {speed:.2g} m/s (expected {SLOWEST:g} to {FASTEST:g}): "
                "are they in Pa and kg/m3, not in MPa, GPa or g/cm3?"
            )
            yield Doubt(MATERIAL, text, speed)
        elif not LIGHTEST <= density <= HEAVIEST:
            text = (
                f"material {name} has rho = {density:.4g} kg/m3 (expected {LIGHTEST:g} to "
                f"{HEAVIEST:g}): is it in kg/m3, not in g/cm3?"
            )
            yield Doubt(MATERIAL, text, density)


def described_doubts(spec: Mapping[str, Any]) -> Iterator[Doubt]:
    """Yield what is unusual about materials and plies of a specification of section or shell."""
    materials = spec["materials"]
    yield from material_doubts(materials)
    for key in ("laminates", "regions"):
        for name, table in spec.get(key, {}).items():
            for i, ply in enumerate(table.get("plies", [table])):
                thickness = ply.get("thickness")
                limits = _thicknesses(materials.get(ply.get("material")))
                if thickness is not None and not limits[0] <= thickness <= limits[1]:
                    text = (
                        f"{key}.{name}{f'.plies[{i}]' if 'plies' in table else ''} is "
                        f"{thickness:.4g} m thick (expected {limits[0]:g} to {limits[1]:g}): is it "
                        "in m, not in mm?"
                    )
                    yield Doubt(SIZE, text, thickness)
                    break


def section_doubts(size: float, mass: float) -> Iterator[Doubt]:
    """Yield what is unusual about size [m] and mass per length [kg/m] of a section."""
    if not SMALLEST_SECTION <= size <= LARGEST_SECTION:
        limits = f"{SMALLEST_SECTION:g} to {LARGEST_SECTION:g}"
        text = f"the section is {size:.4g} m wide (expected {limits}): is its mesh in m, not in mm?"
        yield Doubt(SIZE, text, size)
    elif mass > HEAVIEST_SECTION:
        text = (
            f"the section has a mass of {mass:.4g} kg/m (expected up to {HEAVIEST_SECTION:g}): are "
            "lengths in m, not in mm, and densities in kg/m3?"
        )
        yield Doubt(SIZE, text, mass)


def shell_doubts(spec: Mapping[str, Any], nodes: Array, mass: float) -> Iterator[Doubt]:
    """Yield what is unusual about a shell: thickness against shorter side, mass [kg].

    `nodes` (n, 3) are in any frame [m].

    Parameters
    ----------
    spec : specification of the shell
    nodes : nodes (n, 3), any frame [m]
    mass : mass [kg]
    """
    stacks = [table["plies"] for table in spec.get("laminates", {}).values()]
    layers = [sum(float(ply["thickness"]) for ply in plies) for plies in stacks]
    layers += [float(r["thickness"]) for r in spec["regions"].values() if "thickness" in r]
    centred = nodes - nodes.mean(axis=0)
    along = np.linalg.eigh(centred.T @ centred)[1]
    thickness, width = max(layers), float(np.sort(np.ptp(centred @ along, axis=0))[1])
    if thickness > width > 0.0:
        text = (
            f"the shell is {thickness:.4g} m thick, but its shorter side has {width:.4g} m: are "
            "both in m, not in mm?"
        )
        yield Doubt(SIZE, text, thickness / width)
    yield from body_doubts(mass)


def beam_doubts(width: float, length: float, mass: float) -> Iterator[Doubt]:
    """Yield what is unusual about a beam: largest section's diagonal, length [m], mass [kg].

    Parameters
    ----------
    width : largest diagonal of the sections [m]
    length : length of the beam [m]
    mass : mass [kg]
    """
    if width > length:
        text = f"the beam is {width:.4g} m wide and {length:.4g} m long: are both in m, not in mm?"
        yield Doubt(SIZE, text, width / length)
    yield from body_doubts(mass)


def body_doubts(mass: float, inertia: float = 0.0) -> Iterator[Doubt]:
    """Yield what is unusual about mass [kg] and largest moment of inertia [kg m2] of a body."""
    if mass > HEAVIEST_BODY:
        text = (
            f"the mass is {mass:.4g} kg (expected up to {HEAVIEST_BODY:g}): are lengths in m, not "
            "in mm, and masses in kg?"
        )
        yield Doubt(SIZE, text, mass)
    radius = sqrt(max(inertia, 0.0) / mass) if mass else 0.0
    if mass < THINNEST_BODY * (2.0 * radius) ** 3:
        text = (
            f"a mass of {mass:.4g} kg with a moment of inertia of {inertia:.4g} kg m2 has a radius "
            f"of gyration of {radius:.4g} m: is the inertia in kg m2, not in kg mm2?"
        )
        yield Doubt(SIZE, text, radius)


def gravity_doubts(gravity: float) -> Iterator[Doubt]:
    """Yield whether an acceleration of free fall [m/s2] is unusual."""
    if gravity > STRONGEST_GRAVITY:
        text = (
            f"{gravity:.4g} m/s2 (expected up to {STRONGEST_GRAVITY:g}): is it in m/s2, not in "
            "mm/s2?"
        )
        yield Doubt(SIZE, text, gravity)


def rotor_doubts(density: float, wind: float, tip: float, low: float = 0.0) -> Iterator[Doubt]:
    """Yield what is unusual about a rotor: density [kg/m3], fastest wind and its tip then [m/s].

    Parameters
    ----------
    density : density of the air [kg/m3]
    wind : fastest wind [m/s]
    tip : speed of the tips then [m/s]
    low : least height of a strip in a wind that grows with height [m]
    """
    if low < 0.0:
        text = (
            f"a blade comes down to a height of {low:.4g} m, where a wind that grows with the "
            "height is zero: is the origin of the case on the ground, below the hub?"
        )
        yield Doubt(SIZE, text, low)
    if not any(low <= density <= high for low, high in (AIR, WATER)):
        text = (
            f"air_density = {density:.4g} kg/m3 (expected {AIR[0]:g} to {AIR[1]:g}, or that of "
            "water): is it in kg/m3?"
        )
        yield Doubt(SIZE, text, density)
    if tip > FASTEST_TIP:
        text = (
            f"the tips move at {tip:.4g} m/s (expected up to {FASTEST_TIP:g}; those of the largest "
            "turbines have 80 to 110): is the speed of the shaft in rad/s, not in rpm?"
        )
        yield Doubt(SIZE, text, tip)
    if wind > (CUT_OUT if tip > PARKED else FASTEST_WIND):
        text = (
            f"the wind has {wind:.4g} m/s and the tips {tip:.4g} m/s (turbines stop at 25 to 34 "
            "m/s): is the wind in m/s, not in km/h?"
        )
        yield Doubt(SIZE, text, wind)


def not_allowed(spec: Mapping[str, Any], doubts: Iterable[Doubt]) -> list[Doubt]:
    """Return the doubts that `allow` of a specification does not list."""
    return [doubt for doubt in doubts if doubt.code not in spec.get("allow", ())]


def _thicknesses(material: Any) -> tuple[float, float]:
    """Thinnest and thickest layer of a material [m]."""
    if isinstance(material, Mapping) and "E1" in material:
        if material["E1"] > FIBRES * max(material["E2"], material["E3"]):
            return THINNEST_PLY, THICKEST_PLY
    elif isinstance(material, Mapping) and material.get("E", 0.0) > METAL:
        return 0.0, THICKEST_SHEET
    return 0.0, float("inf")


def _numbers(material: Any) -> tuple[float, float, float] | None:
    """Largest modulus, least modulus or strength [Pa], density (0: not known) [kg/m3]."""
    if not isinstance(material, Mapping):
        return None
    if "C" in material:  # the upper triangle of the stiffness of another code, row by row
        C = material["C"]
        moduli = [abs(float(C[i])) for i in (0, 6, 11, 15, 18, 20)]
    else:
        keys = ("E", "E1", "E2", "E3", "G12", "G13", "G23")
        moduli = [float(material[key]) for key in keys if key in material]
    if not moduli or not min(moduli) > 0.0:  # which is an error elsewhere
        return None
    table = material.get("strength") or {}
    strengths = [float(v) for key, v in table.items() if key != "F12_star" and v is not None]
    return max(moduli), min([*moduli, *strengths]), float(material.get("rho") or 0.0)


def _is_void(name: str, materials: Mapping[str, tuple[float, float, float]]) -> bool:
    stiffest = max(modulus for modulus, _, _ in materials.values())
    heaviest = max(density for _, _, density in materials.values())
    modulus, _, density = materials[name]
    return modulus < VOID * stiffest and density < VOID * heaviest
