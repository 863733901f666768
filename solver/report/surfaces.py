"""The bodies of a result with the surfaces that files of the animation show."""

from pathlib import Path

from ..errors import InputError
from ..results import BodyGeometry, RunResult
from ..results.view import BodyView


def viewed_bodies(result: RunResult, file: Path) -> list[tuple[BodyGeometry, BodyView]]:
    """Return all bodies of a result with their views; `file` names it in the message.

    Raises
    ------
    InputError
        A body has no view.
    """
    found = [(body, body.view) for body in result.bodies if body.view is not None]
    if not found or len(found) < len(result.bodies):
        raise InputError(
            f"{file}: has no surfaces of bodies; expected a result of format 1.2 or later: "
            "run the case again"
        )
    return found
