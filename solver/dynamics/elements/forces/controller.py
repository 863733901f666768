"""PID controller: continuous, or sampled with its output held between the instants.

With the error e = setpoint - sensor, as in K. J. Astrom and T. Hagglund, PID Controllers: Theory,
Design, and Tuning, 2nd ed. (1995), chapter 3:

    demand = kp e + I + D + feedforward,   output = demand within its limits,
    Idot = ki e + (output - demand) / Tt,      the anti-windup by back-calculation,
    D = kd (e - w) / Tf,  wdot = (e - w) / Tf,  the derivative of the filtered error.

Sampled, I takes steps of Euler's method forward, w backward.
"""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from .contract import CoordinateForce, Expression, Number, State, Terms

ERROR = 0.01  # size of an error that counts, for the tolerance of the filter [m, rad]


def _terms(values: Mapping[str, Any]) -> Terms:
    if not any(values[key] for key in ("proportional", "integral", "derivative")):
        raise InputError(": has no effect; expected proportional, integral or derivative")
    lower, upper = values["lower"], values["upper"]
    if lower is not None and upper is not None and not lower < upper:
        raise InputError(f".lower = {lower:g}: expected below upper = {upper:g}")
    if values["anti_windup_time"] is not None and (lower is None and upper is None):
        raise InputError(".anti_windup_time: expected lower or upper, the limits of the output")
    output = "demand"
    if upper is not None:
        output = f"min({output}, upper)"
    if lower is not None:
        output = f"max({output}, lower)"
    sampled = values["sample_time"] is not None
    names = {"error": "setpoint - sensor", "differential": _differential(values)}
    names["demand"] = "proportional * error + integral_part + differential + feedforward"
    names["output"] = output
    states = [_integral(values, "output" if output != "demand" else "")]
    if values["derivative"] and (sampled or values["filter_time"]):
        states.append(_filter(values))
    if not sampled:
        return Terms("gear_ratio * output", names, tuple(states))
    states.append(State("held", None, update="output"))
    return Terms("gear_ratio * held", names, tuple(states))


def _differential(values: Mapping[str, Any]) -> str:
    if not values["derivative"]:
        return "0"
    if values["sample_time"] is not None:
        return "derivative * (error - filtered) / (filter_time + sample_time)"
    if values["filter_time"]:
        return "derivative * (error - filtered) / filter_time"
    return "derivative * rate(error)"


def _integral(values: Mapping[str, Any], output: str) -> State:
    rate, gains = "integral * error", (values["proportional"], values["integral"])
    if output and values["integral"]:
        back = "anti_windup_time"
        if values["anti_windup_time"] is None:
            back = repr(abs(gains[0] / gains[1]) if gains[0] else 1.0)
        rate += f" + (output - demand) / {back}"
    size = max(abs(gain) for gain in gains) * ERROR or 1.0
    if values["sample_time"] is not None:
        update = f"integral_part + sample_time * ({rate})"
        return State("integral_part", None, update=update)
    return State("integral_part", rate if values["integral"] else None, scale=size)


def _filter(values: Mapping[str, Any]) -> State:
    if values["sample_time"] is None:
        rate = "(error - filtered) / filter_time"
        return State("filtered", rate, start="setpoint - sensor", scale=ERROR)
    update = "(filter_time * filtered + sample_time * error) / (filter_time + sample_time)"
    return State("filtered", None, start="setpoint - sensor", update=update)


CONTROLLER = CoordinateForce(
    kind="controller",
    turns=False,
    meaning="a PID controller",
    keys=(
        Expression("setpoint", "", "what the sensor is to follow", required=True),
        Expression("sensor", "", "what is measured; `x`: the coordinate", default="x"),
        Number("proportional", "N or N m by sensor", "gain kp", default=0.0),
        Number("integral", "as proportional, 1/s", "gain ki", default=0.0),
        Number("derivative", "as proportional, s", "gain kd", default=0.0),
        Number(
            "filter_time",
            "s",
            "time constant of the first-order filter of the derivative; 0: none",
            default=0.0,
            least=0.0,
        ),
        Expression("feedforward", "N or N m", "added to the demand", default="0"),
        Number("lower", "N or N m", "limit of the output; absent: none"),
        Number("upper", "N or N m", "limit of the output; absent: none"),
        Number(
            "anti_windup_time",
            "s",
            "in which the integral goes back at a limit; absent: proportional / integral",
            above=0.0,
        ),
        Number(
            "gear_ratio",
            "",
            "force along the coordinate over the output",
            default=1.0,
            not_zero=True,
        ),
        Number(
            "sample_time",
            "s",
            "between the instants at which it acts, its output held; absent: continuous",
            above=0.0,
        ),
    ),
    terms=_terms,
    order=9,
)
