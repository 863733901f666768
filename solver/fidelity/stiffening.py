"""What the omission of geometric stiffening costs, and how fast bodies spin."""

from collections.abc import Mapping

import numpy as np

from ..dynamics.coordinates import move_rows
from ..math.arrays import Array
from ..mechanism import BuiltMechanism
from ..monitors.geometric_stiffness import Loading, geometric_stiffness
from ..monitors.spin import SpinMonitor
from ..signals import Recording, Sensor
from .effects import Effects
from .response import Response, elastic_columns

PARALLEL = 1.0 - 1e-12  # cosine of axes that are the same


def stiffening_loss(
    found: Response,
    again: BuiltMechanism,
    measured: Mapping[str, Sensor],
    second: Mapping[str, Sensor],
    parts: Effects,
) -> Array:
    """Return the change of signals (o, s) by stiffening and second-order motion at q = eta."""
    rows, model = found.at, found.model
    t, y = found.t[rows], found.y[rows].copy()
    change = np.einsum("snm,sm->sn", found.motions[:, : model.n_vel], found.eta[rows])
    move_rows(model, y, change)
    one, two = Recording(model, t, y), Recording(again.model, t, y)
    lost = np.array([second[name].values(two) - measured[name].values(one) for name in measured])
    lost = np.where(np.isfinite(lost), lost, 0.0)
    turned = np.zeros((len(rows), len(found.elastic)))
    loaded = Loading(model)(t, y, (one.rates, one.multipliers))
    for i, columns in enumerate(elastic_columns(model)):
        if len(columns) and again.model.second_start[i + 1] > again.model.second_start[i]:
            Kg = geometric_stiffness(model, again.model, i, t, y, loaded)
            own = np.searchsorted(found.elastic, columns)
            turned[:, own] = np.einsum("sij,sj->si", Kg, found.eta[rows][:, own])
    extra = np.linalg.solve(found.K, turned.T).T  # (s, m)
    eta = found.eta[rows]
    slope = np.divide(
        parts.static[:, rows], eta, out=np.zeros((len(lost), *eta.shape)), where=eta != 0.0
    )
    return np.asarray(lost - np.einsum("osm,sm->os", slope, extra))


def spins(built: BuiltMechanism, found: Response, names: list[str]) -> dict[str, float]:
    """Return the largest spin of bodies over their first clamped frequency."""
    spin = SpinMonitor(built.model, built.body_names, stop=False)
    out = {}
    for i, name in enumerate(built.body_names):
        if name not in names or not built.model.n_mode[i]:
            continue
        w = np.array([spin.spin(i, found.y[k]) for k in found.at.tolist()])
        speed = np.linalg.norm(w, axis=1)
        largest, seen = 0.0, np.zeros((0, 3))
        for k in np.argsort(-speed, kind="stable").tolist():
            if speed[k] <= largest * spin.safe_spin(i):  # that of any axis is higher
                break
            axis = w[k] / speed[k]
            if not (np.abs(seen @ axis) > PARALLEL).any():  # it was faster about this one
                largest = max(largest, float(speed[k] / spin.critical_spin(i, axis)))
                seen = np.vstack([seen, axis])
        out[name] = largest
    return out
