"""Choice of the elements of a shell."""

from collections.abc import Iterable
from typing import NamedTuple

from ....solver.errors import did_you_mean
from ....solver.package.shell import elements
from ..errors import ShellError
from .drilling import DRILLINGS
from .membranes import MEMBRANES
from .plates import PLATES


class Choice(NamedTuple):
    """Names of the elements of triangles and of quadrilaterals, with their parameters.

    Attributes
    ----------
    plate : key of PLATES
    membrane : key of MEMBRANES
    beta0 : factor of the higher-order stiffness of "opt", or "felippa": from the membrane
        stiffness of the laminate
    drilling : key of DRILLINGS, "none", or "auto": "tie" for a membrane without rotations of its
        own, otherwise "none"
    drilling_factor : factor of the drilling stiffness, to the laminate's A66
    quadrilateral : key of QUADS
    """

    plate: str = elements.PLATE
    membrane: str = elements.MEMBRANE
    beta0: float | str = elements.BETA0
    drilling: str = elements.DRILLING
    drilling_factor: float = elements.DRILLING_FACTOR
    quadrilateral: str = elements.QUAD

    def drilling_form(self) -> str:
        """Name of the drilling stiffness, with "auto" resolved."""
        if self.drilling != "auto":
            return self.drilling
        return "none" if MEMBRANES[self.membrane].rotations else "tie"

    def checked(self) -> "Choice":
        """Return itself; raise `ShellError` with key, value and expectation if it is wrong."""
        for key, known in (
            ("plate", PLATES),
            ("membrane", MEMBRANES),
            ("drilling", ("auto", "none", *DRILLINGS)),
            ("quadrilateral", elements.QUADS),
        ):
            _known(key, getattr(self, key), known)
        if isinstance(self.beta0, str):
            if self.beta0 != "felippa":
                raise ShellError(f'beta0 {self.beta0!r}: expected a number above 0 or "felippa"')
        elif not self.beta0 > 0.0:
            raise ShellError(f"beta0 {self.beta0!r}: expected a number above 0")
        if not self.drilling_factor > 0.0:
            raise ShellError(
                f'drilling_factor {self.drilling_factor!r}: expected above 0; drilling = "none" '
                "switches it off"
            )
        return self


def _known(key: str, name: str, known: Iterable[str]) -> None:
    names = list(known)
    if name not in names:
        listed = ", ".join(names)
        raise ShellError(f"{key} {name!r}: expected one of {listed}{did_you_mean(name, names)}")
