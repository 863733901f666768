"""The packages of a run with the modes that it uses, and their initial coordinates."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ...errors import InputError, nearest
from ...package import ModalPackage
from ...package.body.selection import rigid, selected

if TYPE_CHECKING:
    from ...inputs.case.tables.bodies import Deformed
    from ...inputs.case.tables.schema import Mechanism


def used_packages(
    mechanism: "Mechanism", packages: Mapping[str, ModalPackage]
) -> dict[str, ModalPackage]:
    """Return the packages by body, with the modes that the run uses.

    Raises
    ------
    PackageError
        A package without a mode or an interface that `reduced` asks for.
    """
    found = dict(packages)
    for name, body in mechanism.bodies.items():
        if body.kind == "rigid":
            continue
        if body.rigid:
            found[name] = rigid(found[name])
        elif body.reduced is not None:
            tables = [dict(vars(mode)) for mode in body.reduced]
            found[name] = selected(found[name], tables)
    return found


def modal_values(
    name: str, key: str, body: "Deformed", package: ModalPackage
) -> list[tuple[int, float]]:
    """Return the modes and their values of bodies.NAME.KEY (`modal_coordinates`, `modal_rates`).

    Modes have their labels, or their kinds if there is one of a kind, or numbers from 1. A body
    that the run takes as rigid has none.

    Raises
    ------
    InputError
        No such mode; the same mode twice.
    """
    if getattr(body, "rigid", False):
        return []
    labels = list(package.mode_labels or package.mode_kinds)
    known = {label: k for k, label in enumerate(labels) if labels.count(label) == 1}
    known |= {str(k + 1): k for k in range(package.n_mode)}
    found: dict[int, float] = {}
    for word, value in getattr(body, key).items():
        where = f'bodies.{name}.{key} = "{word}"'
        if word not in known:
            raise InputError(f"{where}: no such mode{nearest(word, known)}")
        if known[word] in found:
            raise InputError(f"{where}: expected each mode once; it has another value")
        found[known[word]] = value
    return list(found.items())
