"""Sets of cells that a mesh file names: the regions and curves of a section."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, few, nearest
from ...math.arrays import Array

Mask = NDArray[np.bool_]

WHOLE = "section"  # name of the only region of a mesh without named regions


def region_sets(
    mesh: Any, blocks: list[int], file: str, region_data: str | None
) -> dict[str, Mask]:
    """Return the regions of a mesh as masks over its plane cells; they may overlap.

    Regions are its named cell sets or groups. Without these, they are the values of its integer
    cell data, named "NAME-VALUE". Without cell data, the whole mesh is the region "section".

    Parameters
    ----------
    mesh : as meshio read it
    blocks : rows of mesh.cells with the plane cells
    file : its name, for messages
    region_data : name of the cell data to take the regions from

    Raises
    ------
    InputError
        No such cell data, or several candidates.
    """
    data = {}
    for name, values in mesh.cell_data.items():
        of_cells = np.concatenate([np.asarray(values[i]) for i in blocks])
        if of_cells.size == len(of_cells):  # one value per cell
            data[name] = of_cells.ravel()
    if region_data is not None:
        if region_data not in data:
            raise InputError(
                f'mesh.region_data = "{region_data}": {file} has no such cell data'
                f"{nearest(region_data, data)}"
            )
        return _by_value(region_data, data[region_data])
    sets = named_sets(mesh, blocks)
    if sets:
        return sets
    whole = [name for name, values in data.items() if values.dtype.kind in "iu"]
    if len(whole) > 1:
        raise InputError(
            f"mesh.region_data: missing; {file} has several integer cell data, expected one "
            f"of {few(sorted(whole))}"
        )
    if whole:
        return _by_value(whole[0], data[whole[0]])
    return {WHOLE: np.ones(sum(len(mesh.cells[i].data) for i in blocks), dtype=bool)}


def _by_value(name: str, values: Array) -> dict[str, Mask]:
    short = name.rpartition(":")[2]
    return {f"{short}-{value:g}": values == value for value in np.unique(values)}


def named_sets(mesh: Any, blocks: list[int]) -> dict[str, Mask]:
    """Return cell sets, groups (MED) and physical names as masks over the cells of `blocks`."""
    sizes = [len(mesh.cells[i].data) for i in blocks]
    found: dict[str, Mask] = {}
    for name, members in mesh.cell_sets.items():
        if name.startswith("gmsh:"):  # data that meshio adds
            continue
        masks = [np.zeros(size, dtype=bool) for size in sizes]
        for mask, i in zip(masks, blocks, strict=True):
            if members[i] is not None:
                mask[np.asarray(members[i], dtype=np.int64)] = True
        found[name] = np.concatenate([np.zeros(0, dtype=bool), *masks])
    for number, groups in getattr(mesh, "cell_tags", {}).items():
        tags = [np.asarray(mesh.cell_data["cell_tags"][i]) for i in blocks]
        for group in groups:
            mask = np.concatenate([np.zeros(0), *tags]) == number
            found[group] = found.get(group, np.zeros(mask.size, dtype=bool)) | mask
    return {name: mask for name, mask in found.items() if mask.any()}
