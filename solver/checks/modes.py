"""Whether the vibration modes of each body are enough."""

from collections.abc import Iterator

import numpy as np

from ..results.codes.motion import FEW_MODES
from ..results.finding import Finding
from .finished import FinishedRun

VIBRATION = ("fixed_normal", "experimental")  # kinds of modes, of package.schema.MODE_KINDS


def mode_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield bodies whose highest vibration mode carries much of the strain energy."""
    for i, name in enumerate(run.built.body_names):
        if run.model.n_mode[i] < 2:
            continue
        package = run.packages[name]
        # A static shape carries what it carries: only a series of vibration modes can be too short.
        vibration = [k for k, kind in enumerate(package.mode_kinds) if kind in VIBRATION]
        peak = highest = 0.0
        for _, q in run.modes(i):
            energy = 0.5 * np.diag(package.stiffness) * q**2
            peak = max(peak, float(energy.sum(axis=1).max()))
            if vibration:
                highest = max(highest, float(energy[:, vibration[-1]].max()))
        share = highest / peak if peak > 0 else 0.0
        if share > FEW_MODES.limit:
            text = (
                f"{name}: the highest of {len(vibration)} vibration modes carries {share:.1%} "
                f"of the peak strain energy (expected below {FEW_MODES.limit:.0%}): take more "
                "modes, or static ones where forces act"
            )
            yield FEW_MODES.finding(text, body=name, value=share)
