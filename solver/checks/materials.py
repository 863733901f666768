"""Whether the numbers of a material can be those of a material in SI units."""

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Any

from ..results.codes.course import MATERIAL_UNITS
from ..results.finding import Finding
from .finished import FinishedRun

# Speed of waves along the stiffest axis, sqrt(E / rho) [m/s]: silicone rubber 20 to 40, soft foam
# 50, cork 500, steel 5000, diamond 18 000. With moduli in MPa, plies of carbon fibre have up to 15.
SLOWEST, FASTEST = 20.0, 50_000.0
# A void is a material without effect beside others, as a part of the stiffest and heaviest.
VOID = 1e-3

Materials = dict[str, tuple[float, float]]  # name: largest modulus [Pa], density [kg/m3]


def material_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the materials of the packages whose stiffness does not fit their density."""
    seen: set[tuple[str, float, float]] = set()
    for body, package in run.packages.items():
        for materials in _tables(package.provenance.get("spec")):
            for name, (modulus, density) in materials.items():
                if (name, modulus, density) in seen or _is_void(name, materials):
                    continue
                seen.add((name, modulus, density))
                speed = sqrt(modulus / density)
                if not SLOWEST <= speed <= FASTEST:
                    yield MATERIAL_UNITS.finding(
                        f"{body}: material {name} has E = {modulus:.4g} Pa and rho = "
                        f"{density:.4g} kg/m3, so that waves travel along it at {speed:.2g} m/s "
                        f"(expected {SLOWEST:g} to {FASTEST:g}): are they in Pa and kg/m3, not in "
                        "MPa, GPa or g/cm3?",
                        body=body,
                        value=speed,
                    )


def _tables(spec: Any) -> Iterator[Materials]:
    """Yield every table of materials of a specification, of its sections too."""
    if isinstance(spec, list):
        for item in spec:
            yield from _tables(item)
    if not isinstance(spec, dict):
        return
    for key, value in spec.items():
        if key == "materials" and isinstance(value, dict):
            yield {n: pair for n, m in value.items() if (pair := _numbers(m)) is not None}
        else:
            yield from _tables(value)


def _numbers(material: Any) -> tuple[float, float] | None:
    if not isinstance(material, Mapping) or not material.get("rho"):
        return None
    moduli = [float(material[key]) for key in ("E", "E1", "E2", "E3") if key in material]
    return (max(moduli), float(material["rho"])) if moduli else None


def _is_void(name: str, materials: Materials) -> bool:
    stiffest = max(modulus for modulus, _ in materials.values())
    heaviest = max(density for _, density in materials.values())
    modulus, density = materials[name]
    return modulus < VOID * stiffest and density < VOID * heaviest
