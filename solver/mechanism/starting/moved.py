"""Bodies that had to be moved from their given places to close the joints at the start."""

from typing import TYPE_CHECKING

import numpy as np

from ...dynamics.analysis.scales import extent
from ...dynamics.elements.joints.table import DRIVES, NAMES
from ...dynamics.model.model import Model
from ...errors import few
from ...math.arrays import Array
from ...math.rotations import matrix_to_vector, rotation_matrix
from ...results.codes import START_MOVED, Finding
from ..consistent.initial import Start, closed_by_frames
from ..consistent.locked import rows_of

if TYPE_CHECKING:
    from ...inputs.case.tables.schema import Mechanism


def moved_findings(
    mechanism: "Mechanism", model: Model, start: Start, y0: Array, body_names: list[str]
) -> list[Finding]:
    """Return one finding of all bodies that do not start, in y0 (n,), where the case says.

    Drives are left out: what they prescribe at t = 0 is asked for. So is where a search for
    equilibrium ends, the place of a body that is given none, and that beside given deformations.
    """
    bodies = mechanism.bodies
    deformed = any(getattr(body, "modal_coordinates", None) for body in bodies.values())
    if mechanism.solver.start == "equilibrium" or deformed or not model.n_constraint:
        return []
    if not _moved(model, start.positions, y0, body_names):
        return []
    rows = np.ones(model.n_constraint, dtype=bool)
    for joint, kind in enumerate(model.joint_kind):
        if NAMES[kind] in DRIVES:
            rows[rows_of(model, joint)] = False
    given = np.concatenate([start.positions, np.zeros(model.n_vel), model.quantities.start, [0.0]])
    y = closed_by_frames(model, given, rows)
    found = []
    for share, i, distance, angle in _moved(model, given, y, body_names):
        name, place = body_names[i], y[int(model.pos_start[i]) :][:7]
        keys = "" if getattr(bodies.get(name), "part_of", None) else _keys(place)
        found.append((share, f"{name} by {distance:.3g} m and {np.degrees(angle):.3g} deg{keys}"))
    if not found:
        return []
    listed = few((words for _, words in sorted(found, reverse=True)), "; ")
    text = (
        f"to close the joints at the start, bodies were moved from their given places: {listed}. "
        "If this is the start that is meant, give these values; if not, check lengths, ground "
        "points, axes and positions"
    )
    return [START_MOVED.finding(text, t=0.0, value=max(found)[0])]


def _moved(
    model: Model, given: Array, y: Array, body_names: list[str]
) -> list[tuple[float, int, float, float]]:
    """Return share, index, distance [m] and angle [rad] of bodies beyond the limit in y."""
    size, found = extent(model, y), []
    for i in range(len(body_names)):
        a = int(model.pos_start[i])
        turn = rotation_matrix(given[a + 3 : a + 7]).T @ rotation_matrix(y[a + 3 : a + 7])
        angle = float(np.linalg.norm(matrix_to_vector(turn)))
        distance = float(np.linalg.norm(y[a : a + 3] - given[a : a + 3]))
        share = max(angle, distance / size if given[a : a + 3].any() else 0.0)
        if share > START_MOVED.limit:
            found.append((share, i, distance, angle))
    return found


def _keys(place: Array) -> str:
    """Return the keys that give a body this place (7,), in brackets."""
    turn = np.degrees(matrix_to_vector(rotation_matrix(place[3:])))
    position, rotation = (
        ", ".join(f"{x:.9g}" for x in np.round(part, 9) + 0.0) for part in (place[:3], turn)
    )
    return f" (position = [{position}], rotation_deg = [{rotation}])"
