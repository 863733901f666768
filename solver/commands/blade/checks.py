"""Sizes and layers of a blade that cannot be, and those that are unlike any blade."""

from collections.abc import Iterator, Sequence

import numpy as np

from .shape import Layer, Shape
from .tables import Tables

LONGEST, WIDEST = 300.0, 30.0  # [m] the longest blades are 150 m, with a chord of 8 m
SLENDER, STOUT = 0.005, 0.5  # chord over length; blades have 0.03 to 0.25
TWISTED = 45.0  # [deg] blades have up to 25
NO_ARC = 1e-9  # [-]
NOTHING = 1e-9  # [m] thickness that is round-off


def doubts(shape: Shape) -> Iterator[str]:
    """Yield sizes that are possible, but unlike blades: key and words."""
    length = float(np.ptp(shape.length.values))
    chord, twist = float(shape.chord.values.max()), float(np.abs(shape.twist.values).max())
    if length > LONGEST:
        yield f"reference_axis.z.values: a blade of {length:g} m; expected metres"
    if chord > WIDEST or not SLENDER < chord / length < STOUT:
        yield (
            f"outer_shape.chord.values: up to {chord:g} m, {chord / length:.3g} of the length of "
            f"{length:g} m; expected metres"
        )
    if twist > TWISTED:
        yield f"outer_shape.twist.values: up to {twist:g}; expected degrees"


def check_layers(tables: Tables, shape: Shape, layers: Sequence[Layer]) -> None:
    """Refuse layers that cannot be.

    Raises
    ------
    InputError : a negative thickness, one above that of the section, or nowhere an arc.
    """
    for i, layer in enumerate(layers):
        path, t = f"structure.layers[{i}]", layer.thickness
        if t.values.min() < -NOTHING:
            words = f"{t.values.min():g} of {layer.name}; expected 0 or more [m]"
            raise tables.error(f"{path}.thickness.values", words)
        for r, value in zip(t.grid.tolist(), t.values.tolist(), strict=True):
            room = shape.chord.at(r) * shape.thickness.at(r)
            if value > room:
                words = f"{value:g} of {layer.name} at r = {r:g}, where the section is {room:.3g} m"
                raise tables.error(f"{path}.thickness.values", f"{words} thick; expected metres")
        if layer.web or not t.values.any():
            continue
        grid = np.union1d(np.union1d(layer.start.grid, layer.end.grid), t.grid)
        arcs = np.array([[one.at(r) for one in (layer.start, layer.end)] for r in grid])
        around = (arcs[:, 0] > 0.5) & (arcs[:, 1] < 0.5)
        if not (around | (arcs[:, 1] - arcs[:, 0] > NO_ARC)).any():
            (start, end) = arcs[0]
            words = f"{layer.name} begins at {start:g} and ends at {end:g}; expected an end behind"
            raise tables.error(f"{path}.end_nd_arc", f"{words} the start")
