"""Checks of places, expressions and combined signals: names, functions, dependence."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ....dynamics.model.model import LAST
from ....errors import InputError, nearest, unknown
from ....math import laws
from ....math.curves import NamedCurve
from ....math.expressions import operations as op
from ....math.expressions.parse import MADE, NAMES
from ....math.rows import column
from ..expressions.expressions import WORDS, CaseScope, PlaceCheck, expression, of_time_alone
from ..expressions.force_terms import force_terms
from ..expressions.of_time import law
from ..tables.beam_schema import BeamBody
from ..tables.body_schema import ImportedBody, PackageBody, RigidBody, ShellBody, SolidBody
from ..tables.combining import KINDS, elsewhere, parts
from ..tables.kinds import CoordinateTable, ForceTable
from ..tables.laws import DriveTable, RotationDrive, TranslationDrive
from ..tables.schema import Mechanism

Body = BeamBody | ShellBody | SolidBody | RigidBody | PackageBody | ImportedBody


def interfaces(body: Body) -> list[str] | None:
    """Return the interface names of a body; None if another file has them."""
    return None if isinstance(body, PackageBody | ImportedBody) else list(body.interfaces)


def check_place(key: str, place: str, mechanism: Mechanism, *, ground: bool) -> list[str]:
    """Return errors of a place "BODY.INTERFACE" or "ground.POINT"."""
    owner, dot, point = place.partition(".")
    if not dot:
        expected = '"BODY.INTERFACE"' + (' or "ground.POINT"' if ground else "")
        return [f'{key} = "{place}": expected {expected}']
    if owner == "ground" and ground:
        if point in mechanism.ground:
            return []
        hint = nearest(point, mechanism.ground)
        return [f'{key} = "{place}": the ground has no point "{point}"{hint}']
    if owner not in mechanism.bodies:
        return [f'{key} = "{place}": there is no body "{owner}"{nearest(owner, mechanism.bodies)}']
    known = interfaces(mechanism.bodies[owner])
    if known is not None and point not in known:
        return [
            f'{key} = "{place}": body "{owner}" has no interface "{point}"{nearest(point, known)}'
        ]
    return []


def check_combined(mechanism: Mechanism) -> Iterator[str]:
    """Yield what is wrong with the combined signals of a run, apart from the other run."""
    signals: Mapping[str, Any] = mechanism.signals
    for name, signal in signals.items():
        if signal.kind not in KINDS:
            continue
        for part in parts(signal):
            yield from unknown(f"signals.{name}.of", part, "signal", signals)
        if _depends_on(name, name, signals, frozenset()):
            yield f"signals.{name}: depends on itself; expected other signals"
        if mechanism.fidelity is not None and signal.run is not None:
            yield f"signals.{name}.run: expected none with [fidelity]"


def _depends_on(name: str, wanted: str, signals: Mapping[str, Any], seen: frozenset[str]) -> bool:
    if name in seen or name not in signals:
        return False
    inner = parts(signals[name])
    return wanted in inner or any(
        _depends_on(part, wanted, signals, seen | {name}) for part in inner
    )


def check_elsewhere(mechanism: Mechanism, runs: Mapping[str, Mechanism]) -> Iterator[str]:
    """Yield what is wrong with the runs that the combined signals of a run read."""
    signals: Mapping[str, Any] = mechanism.signals
    for name, signal in signals.items():
        if not elsewhere(signal):
            continue
        if signal.run not in runs:
            yield from unknown(f"signals.{name}.run", signal.run, "run", runs)
            continue
        there: Mapping[str, Any] = runs[signal.run].signals
        for part in elsewhere(signal):
            if part not in there:
                yield f'signals.{name}: run {signal.run} has no signal "{part}"'
            elif elsewhere(there[part]):
                yield f'signals.{name}: "{part}" reads another run itself; expected a plain signal'


RESTS = 0.01  # of the largest speed of a table of a drive: it has come to rest


def check_force(key: str, force: ForceTable, mechanism: Mechanism) -> list[str]:
    """Return errors of the expressions of a force."""
    name = key.partition(".")[2]
    try:
        if isinstance(force, CoordinateTable):
            force_terms(name, force, mechanism, _places(mechanism))
            return []
        of_time = law(force)
        if of_time is not None and of_time.expression is not None:
            scope = CaseScope(mechanism, check=_places(mechanism))
            expression(of_time.expression, scope, f"{key}.expression")
    except InputError as error:
        return [str(error)]
    return []


def check_tables(mechanism: Mechanism) -> list[str]:
    """Return tables whose names mean something else in expressions."""
    others = {
        "a function of expressions": {*op.FUNCTIONS, *MADE, *WORDS},
        "a name of expressions": {*NAMES, "x", "v"},
        "one of [parameters] too": mechanism.parameters,
    }
    return [
        f"tables.{name}: is {what}; expected another name"
        for name in mechanism.tables
        for what, words in others.items()
        if name in words
    ]


def _places(mechanism: Mechanism) -> PlaceCheck:
    return lambda place: check_place("reads", place, mechanism, ground=True)


def _stop(key: str, table: DriveTable, t_end: float) -> list[str]:
    """Return the error of a table that ends within the run before its curve has come to rest."""
    times, values = column(table.times or []), column(table.values or [])
    if times[-1] >= t_end * (1.0 - LAST):
        return []
    curve = laws.table(times, values, table.interpolation)
    s, c = times[-1] - times[-2], curve.coefficients
    speed = float(sum(i * c[-2, i] * s ** (i - 1) for i in range(1, c.shape[1])))
    if abs(speed) <= RESTS * max(float(np.abs(c[:, 1]).max()), abs(speed)):
        return []
    return [
        f"{key}.table: ends at t = {times[-1]:g} s with a speed of {speed:.3g}, and the drive "
        f"would stop there at once, because the last value is kept; expected times up to "
        f"solver.t_end = {t_end:g} s, or values that come to rest"
    ]


def check_drive(
    key: str, drive: RotationDrive | TranslationDrive, mechanism: Mechanism
) -> list[str]:
    """Return errors of the law of a drive: an expression reads the time alone, no speed jumps."""
    if drive.table is not None:
        return _stop(key, drive.table, mechanism.solver.t_end)
    if drive.expression is None:
        return []
    try:
        tree = expression(drive.expression, CaseScope(mechanism), f"{key}.expression")
    except InputError as error:
        return [str(error)]
    if not of_time_alone(tree):
        return [
            f'{key}.expression = "{drive.expression}": expected the time t and parameters alone; '
            "a drive that follows the motion is a controller or coordinate_force"
        ]
    for leaf in tree.leaves():
        curve = leaf.quantity
        if isinstance(curve, NamedCurve) and mechanism.tables[curve.name].interpolation == "linear":
            return [
                f"{key}.expression: calls tables.{curve.name}, whose rate jumps; expected "
                'interpolation = "cubic" or "pchip" in a drive'
            ]
    return []
