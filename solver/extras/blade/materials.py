"""Materials of a windIO file, as a section description has them."""

from collections.abc import Set

import numpy as np

from ...package.common.materials import MaterialError, Orthotropic
from .tables import Table, Tables

GLUE = "adhesive"  # part of the name of the material of bond lines
# Epoxy adhesives of blades have 2 to 5 GPa, polyurethane ones 0.3 and more. Files that have MPa for
# GPa, or a placeholder, would leave the trailing edge open.
SOFT_GLUE = 1e8  # [Pa]
# A solid of nu = 0.5 keeps its volume, and its stiffness is infinite. Foam, balsa and paint are too
# soft for it to matter: 0.49 in place of 0.499 changes K of IEA-10-198-RWT by 2e-4 (docs/blade.md).
LARGEST_NU, INCOMPRESSIBLE = 0.49, 0.5
FREE_G = 0.25  # relative difference of a given G from E / (2 (1 + nu)) from which a finding says so


class Materials:
    """Reads materials; what is unusual about them is in `doubts`, as key and words."""

    def __init__(self, tables: Tables, top: Table) -> None:
        self.tables, self.doubts = tables, list[str]()
        self.entries = tables.named(top, "materials")

    def read(self, used: Set[str]) -> dict[str, Table]:
        """Return the materials that are used, and adhesives; others may have other keys."""
        materials = {
            name: self._material(entry, f"materials.{name}")
            for name, entry in self.entries.items()
            if name in used or GLUE in name.lower()
        }
        self.doubts += [
            f"materials.{name}: E is below {SOFT_GLUE:g} Pa, which joins no walls; the innermost "
            "layer closes sharp trailing edges instead"
            for name, material in materials.items()
            if GLUE in name.lower() and name not in used and is_soft(material)
        ]
        return materials

    def _number(self, entry: Table, path: str) -> float:
        return float(self.tables.numbers(entry, path, 1)[0])

    def _material(self, entry: Table, path: str) -> Table:
        rho = self._number(entry, f"{path}.rho")
        if not entry.get("orth"):
            return self._isotropic(entry, path) | {"rho": rho}
        constants = {"rho": rho}
        for key, names in (
            ("E", ("E1", "E2", "E3")),
            ("G", ("G12", "G13", "G23")),
            ("nu", ("nu12", "nu13", "nu23")),
        ):
            values = self.tables.numbers(entry, f"{path}.{key}", 3).tolist()
            constants |= dict(zip(names, values, strict=True))
        strength = {"strength": s} if (s := _strength(entry)) else {}
        return {"kind": "orthotropic", **self._elastic(constants, path), **strength}

    def _isotropic(self, entry: Table, path: str) -> dict[str, object]:
        E, nu = (self._number(entry, f"{path}.{key}") for key in ("E", "nu"))
        if LARGEST_NU < nu <= INCOMPRESSIBLE:
            self.doubts.append(
                f"{path}.nu = {nu:g}: a solid that keeps its volume; {LARGEST_NU:g} is used"
            )
            nu = LARGEST_NU
        if isinstance(G := entry.get("G"), int | float) and E > 0.0 and nu > -1.0:
            expected = E / (2.0 * (1.0 + nu))
            if abs(G / expected - 1.0) > FREE_G:
                self.doubts.append(
                    f"{path}.G = {G:.4g} Pa: an isotropic material of this E and nu has "
                    f"{expected:.4g} Pa, which is used"
                )
        return {"kind": "isotropic", "E": E, "nu": nu}

    def _elastic(self, constants: dict[str, float], path: str) -> dict[str, float]:
        """Constants of an elastic material: without ratios across the wall that none has.

        Walls have no stress across, so that nu13 and nu23 matter little, and files of thin-walled
        codes have placeholders there.
        """
        try:
            Orthotropic(**constants)
        except MaterialError:
            plane = constants | {"nu13": 0.0, "nu23": 0.0}
            try:
                Orthotropic(**plane)
            except MaterialError:
                return constants  # the section description names what is wrong
            ratios = ", ".join(f"{constants[key]:g}" for key in ("nu12", "nu13", "nu23"))
            self.doubts.append(
                f"{path}.nu = [{ratios}]: no elastic material has these ratios; "
                "nu13 = nu23 = 0 is used"
            )
            return plane
        return constants


def is_soft(adhesive: Table) -> bool:
    """True for an adhesive that cannot join walls."""
    return bool(adhesive.get("E", adhesive.get("E1", SOFT_GLUE)) < SOFT_GLUE)


def _strength(entry: Table) -> dict[str, float]:
    """Strengths of a ply; files without them write zeros or infinity."""
    try:
        Xt, Xc, S = (np.array(entry[key], dtype=float) for key in ("Xt", "Xc", "S"))
        values = np.array([Xt[0], Xc[0], Xt[1], Xc[1], S[0]])
    except (KeyError, TypeError, ValueError, IndexError):
        return {}
    if not (np.isfinite(values).all() and values.min() > 0.0):
        return {}
    return dict(zip(("Xt", "Xc", "Yt", "Yc", "S12"), values.tolist(), strict=True))
