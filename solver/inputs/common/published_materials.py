"""Materials by name, with published values; what a source leaves out is left out here."""

from dataclasses import dataclass
from typing import Any

from ...errors import nearest

WWFE = (
    "Soden, Hinton, Kaddour: Compos. Sci. Technol. 58 (1998) 1011 (World-Wide Failure Exercise); "
    "transversely isotropic; no density"
)
HANDBOOK = "MIL-HDBK-5J (2003), {}: modulus in tension at room temperature; no strength"
GPA, MSI, LB_IN3 = 1e9, 6.894757e9, 27679.9  # [Pa], [Pa], [kg/m3]


@dataclass(frozen=True)
class Published:
    """A material of the library: keys of `[materials.NAME]` in SI."""

    meaning: str
    source: str
    table: dict[str, object]


def _ply(meaning: str, elastic: tuple[float, ...], strengths: tuple[float, ...]) -> Published:
    """Return a ply from E1, E2, G12 [GPa], nu12, nu23 and Xt, Xc, Yt, Yc, S12 [MPa]."""
    E1, E2, G12, nu12, nu23 = elastic
    table = {
        "kind": "orthotropic",
        **{"E1": E1 * GPA, "E2": E2 * GPA, "E3": E2 * GPA, "G12": G12 * GPA, "G13": G12 * GPA},
        "G23": round(E2 / (2.0 * (1.0 + nu23)), 3) * GPA,
        **{"nu12": nu12, "nu13": nu12, "nu23": nu23},
        "strength": {
            key: value * 1e6
            for key, value in zip(("Xt", "Xc", "Yt", "Yc", "S12"), strengths, strict=True)
        },
    }
    return Published(meaning, WWFE, table)


def _metal(meaning: str, table: str, E_msi: float, nu: float, rho_lb_in3: float) -> Published:
    E, rho = round(E_msi * MSI, -8), round(rho_lb_in3 * LB_IN3, 0)
    source = HANDBOOK.format(table)
    return Published(meaning, source, {"kind": "isotropic", "E": E, "nu": nu, "rho": rho})


LIBRARY = {
    "as4-3501-6": _ply(
        "carbon/epoxy", (126.0, 11.0, 6.6, 0.28, 0.4), (1950.0, 1480.0, 48.0, 200.0, 79.0)
    ),
    "t300-bsl914c": _ply(
        "carbon/epoxy", (138.0, 11.0, 5.5, 0.28, 0.4), (1500.0, 900.0, 27.0, 200.0, 80.0)
    ),
    "e-glass-ly556": _ply(
        "glass/epoxy", (53.48, 17.7, 5.83, 0.278, 0.4), (1140.0, 570.0, 35.0, 114.0, 72.0)
    ),
    "e-glass-my750": _ply(
        "glass/epoxy", (45.6, 16.2, 5.83, 0.278, 0.4), (1280.0, 800.0, 40.0, 145.0, 73.0)
    ),
    "al-2024-t3": _metal("aluminium alloy, sheet", "Table 3.2.3.0(b1)", 10.5, 0.33, 0.100),
    "al-6061-t6": _metal("aluminium alloy, sheet", "Table 3.6.2.0(b1)", 9.9, 0.33, 0.098),
    "al-7075-t6": _metal("aluminium alloy, sheet", "Table 3.7.6.0(b1)", 10.3, 0.33, 0.101),
    "steel-4130": _metal("low-alloy steel", "section 2.3.1", 29.0, 0.32, 0.283),
    "ti-6al-4v": _metal("titanium alloy, sheet", "Table 5.4.1.0(b)", 16.0, 0.31, 0.160),
}


def with_published(table: Any) -> Any:
    """Return the keys of a material: those of the library that a text or `library` names, too.

    Raises
    ------
    ValueError : no such material.
    """
    given = {"library": table} if isinstance(table, str) else table
    name = given.get("library") if isinstance(given, dict) else None
    if not isinstance(name, str):
        return table
    if name not in LIBRARY:
        raise ValueError(f'no material "{name}" in the library{nearest(name, LIBRARY)}')
    own = {key: value for key, value in given.items() if key != "library"}
    return {**LIBRARY[name].table, **own}
