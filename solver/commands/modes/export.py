"""Linearised equations as files for NumPy and MATLAB."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from ...linearisation.named_states import Realisation, realisation
from ...linearisation.participation import coordinate_names
from ...package.common.temporary import temporary_sibling
from .found import Found
from .state import States


def write_linear(folder: Path, states: States, found: Found) -> Realisation:
    """Write linear.npz and linear.mat: A, B, C, D with names and units of what they connect."""
    built = states.built
    names = coordinate_names(built.model, built.body_names, built.packages)
    system = realisation(found.space, names, built.state_names)
    matrices: dict[str, Any] = {key: getattr(system, key) for key in "ABCD"}
    words = {
        "states": system.states,
        "inputs": system.inputs,
        "input_units": system.input_units,
        "outputs": system.outputs,
        "output_units": system.output_units,
    }
    modes = {
        "eigenvalues": found.modes.eigenvalues,
        "shapes": found.modes.x,
        "t": np.array(found.state.t),
        "spin": found.state.spin.W if found.state.spin is not None else np.zeros(3),
    }
    texts = {key: np.array(value, dtype=str) for key, value in words.items()}
    coordinates = np.array(names, dtype=str)
    with temporary_sibling(folder / "linear.npz") as temporary:
        content: dict[str, Any] = {**matrices, **texts, **modes, "coordinates": coordinates}
        np.savez(temporary, **content)
    cells = {key: np.array(value, dtype=object)[:, None] for key, value in words.items()}
    cells["coordinates"] = np.array(names, dtype=object)[:, None]
    with temporary_sibling(folder / "linear.mat") as temporary:
        savemat(temporary, {**matrices, **cells, **modes}, do_compression=True)
    return system
