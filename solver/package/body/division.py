"""Division of a beam into elements."""

from itertools import pairwise

import numpy as np

from ...math.arrays import Array


def node_positions(length: float, elements: int, stops: list[float]) -> Array:
    """Divide a beam into elements with a node at every stop.

    Parameters
    ----------
    length : length of the beam [m]
    elements : total number of elements
    stops : fractions of the length (0 to 1) that need a node

    Returns
    -------
    (elements + 1,) positions [m]: uniform if the stops allow it, otherwise
    uniform between stops, with the elements distributed by length.

    Raises
    ------
    ValueError : fewer elements than stretches between stops.
    """
    inner = sorted({0.0, 1.0, *stops})
    cuts = [inner[0]] + [b for a, b in pairwise(inner) if b - a > 1e-9]
    cuts[-1] = 1.0
    stretches = np.diff(cuts)
    if elements < len(stretches):
        raise ValueError(
            f"expected at least {len(stretches)}, one between any two neighbouring interfaces"
        )
    # each additional element goes to the stretch with the longest elements
    counts = np.ones(len(stretches), dtype=int)
    for _ in range(elements - len(stretches)):
        counts[np.argmax(np.round(stretches / counts, 12))] += 1
    parts = [
        np.linspace(a, b, k, endpoint=False)
        for a, b, k in zip(cuts[:-1], cuts[1:], counts, strict=True)
    ]
    return length * np.append(np.concatenate(parts), 1.0)
