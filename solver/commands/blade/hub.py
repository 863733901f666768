"""The hub of a windIO turbine: where the root of a blade is, and its cone."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

UPWIND = "upwind"


@dataclass(frozen=True)
class Hub:
    """The place of the root of a blade. A file without a hub: on the axis, without cone."""

    radius: float = 0.0  # [m] from the axis to the root, along the blade
    cone_deg: float = 0.0  # positive: the tip to the pressure side, as upwind rotors have it


NO_HUB = Hub()


def read_hub(table: Mapping[str, Any]) -> Hub:
    """Return the hub of a windIO table; what it does not have, or not as a number, is 0."""
    components, assembly = table["components"], table.get("assembly")
    hub = components.get("hub")
    hub = hub if isinstance(hub, dict) else {}
    orientation = assembly.get("rotor_orientation") if isinstance(assembly, dict) else None
    sign = 1.0 if str(orientation or UPWIND).lower() == UPWIND else -1.0
    return Hub(0.5 * _number(hub.get("diameter")), sign * _number(hub.get("cone_angle")))


def _number(value: Any) -> float:
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        return 0.0
    return found if math.isfinite(found) else 0.0
