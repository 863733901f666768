"""Indicators of a plan: what the omission of modes, static shapes and stiffening costs."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from ....checks.stability import Loading, SpinMonitor, geometric_stiffness
from ....dynamics.analysis.recovery import extent, shape_sizes
from ....dynamics.model.coordinates import move_rows
from ....math.arrays import Array
from ....mechanism.built_mechanism import BuiltMechanism
from ....package import ModalPackage
from ....package.body.selection import vibrations
from ....run.inputs import RunSpec
from ....run.timing import work_s
from ....signals import Recording, Sensor, sensors
from ..comparison import bends, kind_of_signal, relatives, scales
from .base_motion import Study, base_motion, built_with, loaded
from .response import Effects, Indicators, Mode, Response, effects, elastic_columns, response


def _stiffening_loss(
    response: Response,
    again: BuiltMechanism,
    measured: Mapping[str, Sensor],
    second: Mapping[str, Sensor],
    parts: Effects,
) -> Array:
    """Return the change of signals (o, s) by stiffening and second-order motion at q = eta."""
    rows, model = response.at, response.model
    t, y = response.t[rows], response.y[rows].copy()
    change = np.einsum("snm,sm->sn", response.motions[:, : model.n_vel], response.eta[rows])
    move_rows(model, y, change)
    one, two = Recording(model, t, y), Recording(again.model, t, y)
    lost = np.array([second[name].values(two) - measured[name].values(one) for name in measured])
    lost = np.where(np.isfinite(lost), lost, 0.0)
    turned = np.zeros((len(rows), len(response.elastic)))
    loaded = Loading(model)(t, y, (one.rates, one.multipliers))
    for i, columns in enumerate(elastic_columns(model)):
        if len(columns) and again.model.second_start[i + 1] > again.model.second_start[i]:
            Kg = geometric_stiffness(model, again.model, i, t, y, loaded)
            own = np.searchsorted(response.elastic, columns)
            turned[:, own] = np.einsum("sij,sj->si", Kg, response.eta[rows][:, own])
    extra = np.linalg.solve(response.K, turned.T).T  # (s, m)
    eta = response.eta[rows]
    slope = np.divide(
        parts.static[:, rows], eta, out=np.zeros((len(lost), *eta.shape)), where=eta != 0.0
    )
    return np.asarray(lost - np.einsum("osm,sm->os", slope, extra))


def _spins(built: BuiltMechanism, response: Response, names: list[str]) -> dict[str, float]:
    """Return the largest spin of bodies over their first clamped frequency."""
    spin = SpinMonitor(built.model, built.body_names, stop=False)
    out = {}
    for i, name in enumerate(built.body_names):
        if name not in names or not built.model.n_mode[i]:
            continue
        w = np.array([spin.spin(i, response.y[k]) for k in response.at.tolist()])
        speeds = np.linalg.norm(w, axis=1)
        k = int(np.argmax(speeds))
        if speeds[k] > 0.0:
            out[name] = float(speeds[k] / spin.critical_spin(i, w[k] / speeds[k]))
    return out


def _amplified_errors(response: Response, parts: Effects, scale: Array) -> Array:
    """Return the error (o,) of the signals over the tolerance of the integrator, of the scale.

    A tolerance of 1 permits errors of the modes that displace a body by the size of the mechanism.
    What the modes of a body add to a signal has that size over their displacement as its error.
    """
    model, q = response.model, response.history[0]
    size, first, worst = extent(model, response.y[0]), 0, np.zeros(len(scale))
    for i in range(model.n_body):
        m = int(model.n_mode[i])
        mine = slice(first, first + m)
        moved = float(np.linalg.norm(q[:, mine] * shape_sizes(model, i), axis=1).max(initial=0.0))
        first += m
        if moved > 0.0:
            added = np.abs(parts.response[:, :, mine].sum(axis=2)).max(axis=1) / scale
            worst = np.maximum(worst, added * size / moved)
    return worst


def study(
    spec: RunSpec, check: Mapping[str, ModalPackage], names: list[str], signals: list[str]
) -> Study:
    """Return what a plan is made from.

    Parameters
    ----------
    spec : the run with the rich packages of the model
    check : rich packages of the check
    names : flexible bodies that the plan is about
    signals : names of the signals that must be accurate
    """
    begin = work_s()
    base = base_motion(spec, names, spec.fidelity.budget)
    moved = work_s()
    model = loaded(spec, base, spec.packages, names)
    mechanism, metric, modes = spec.mechanism, spec.fidelity.metric, []
    for name in model.built.body_names:
        if name in model.rich:
            package = model.rich[name].package
            moving, rows = vibrations(package), model.modes[name].tolist()
            modes += [Mode(name, package.mode_labels[j], j in moving) for j in rows]
    driven = response(base, model.built.model, model.p, mechanism.solver.start)
    wanted = {name: mechanism.signals[name] for name in signals}
    compared = relatives(signals, mechanism, model.built, driven.y[0])
    measured = compared.sensors(model.built)
    kinds = {name: kind_of_signal(name, compared.table) for name in measured}
    bent = {name for name in measured if bends(name, compared.table)}
    every = effects(driven, measured, kinds, bent)
    whole, sizes = compared.judged(dict(zip(measured, every.whole, strict=True)))
    quiet = np.asarray(sizes > 0.0)
    scale = np.where(quiet, sizes, scales(metric, whole))
    count = len(signals)  # relatives follow
    parts = Effects(every.base[:count], every.response[:count], every.static[:count])
    stiffened = np.zeros(count)
    if any(package.second_order is not None for package in model.packages.values()):
        again = built_with(spec, model.packages, stiffening=True)
        second = sensors(again, mechanism.signals, wanted=wanted)
        first = {name: measured[name] for name in signals}
        lost = _stiffening_loss(driven, again, first, second, parts)
        stiffened = np.abs(lost).max(axis=1) / scale
    spin, amplified = _spins(model.built, driven, names), _amplified_errors(driven, parts, scale)
    indicators = Indicators(
        list(signals), metric, scale, modes, parts, stiffened, spin, amplified, quiet
    )
    cpu = {"base": moved - begin, "indicators": work_s() - moved}
    of_check = partial(loaded, spec, base, check, names)
    return Study(base, model.rich, of_check, indicators, cpu)
