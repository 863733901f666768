"""The packages of a run: those that were built, or what the run uses of them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..package import ModalPackage
from ..package.body.selection import selected
from ..package.body.transform import rigid

if TYPE_CHECKING:
    from ..inputs.case.schema import Mechanism


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
