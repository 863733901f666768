"""The case of a turning blade: the beam of a blade's table on the hub of its file."""

import math
import shlex
from collections.abc import Sequence
from pathlib import Path

from ...errors import printable
from ...inputs.case.file import CASE_FILE
from ...package.common.temporary import write_text
from ...package.common.toml_text import toml_value
from .stations import Station, complete
from .windio import Blade

ELEMENTS = 60  # at least, of a blade
MODES = 10  # vibrations of the body
TIP_SPEED = 80.0  # [m/s] of the run

TEXT = """\
# The blade of {file_name} on a hub that turns, written by `plymotion blade`.
#   plymotion modes {file} --at spin=0:{speed:.3g}:{step:.3g} --count 6    frequencies over speed
#   plymotion {file}    the run: from rest to {speed:.3g} rad/s, {tip:.0f} m/s at the tip
# beam.csv has the line and the 6x6 stiffness and mass of {stations} stations. No weight, no air.

format = 1
title = {title}

[bodies.hub] # its motion is prescribed, so its mass has no influence
kind = "rigid"
mass = 1000.0
inertia = [[1000.0, 0.0, 0.0], [0.0, 1000.0, 0.0], [0.0, 0.0, 1000.0]]
interfaces = {{ axis = {{ position = [0.0, 0.0, 0.0] }}, rim = {{ position = {root} }} }}

[bodies.blade] # x to the tip, y to the leading edge, z to the suction side
kind = "beam"
table = "beam.csv"
elements = {elements}
modes = [{{ kind = "lowest", count = {modes} }}, {{ kind = "static-axial" }}]
position = {root} # at the radius of the hub, {radius:g} m
rotation_deg = [0.0, {cone!r}, 0.0] # the cone
reference = {{ kind = "clamped", at = "root" }}
interfaces = {{ root = {{ at = "start" }}, tip = {{ at = "end" }} }}

[ground.axis]
position = [0.0, 0.0, 0.0]

[joints.axis]
kind = "revolute"
between = ["ground.axis", "hub.axis"]
axis = [0.0, 0.0, 1.0] # the leading edge leads
drive = {{ ramp = {{ speed = {speed:.6g}, duration = 20.0 }} }}

[joints.clamp]
kind = "fixed"
between = ["hub.rim", "blade.root"]

[signals.flap]
kind = "deflection"
at = "blade.tip"
component = "z"
description = "tip, to the suction side"

[signals.edge]
kind = "deflection"
at = "blade.tip"
component = "y"
description = "tip, to the leading edge"

[solver]
t_end = 25.0
output_step = 0.05
geometric_stiffening = true

[runs.spin-up]
title = "spin-up"

[figures.flap]
title = "Deflection of the tip"
signal = "flap"
runs = ["spin-up"]
"""


def write_blade_case(blade: Blade, stations: Sequence[Station], folder: Path) -> Path:
    """Write the case of a blade whose table beam.csv is in `folder`; returns its file."""
    count = len(complete(stations))
    radius, cone = blade.hub.radius, blade.hub.cone_deg
    angle = math.radians(cone)
    length = float(blade.length.values[-1] - blade.length.values[0])
    speed = TIP_SPEED / (radius + length)
    file = folder / CASE_FILE
    text = TEXT.format(
        file_name=printable(blade.file.name),
        title=toml_value(f"Blade of {blade.file.name}"),
        file=printable(shlex.quote(str(file))),
        speed=speed,
        step=speed / 8.0,
        tip=TIP_SPEED,
        stations=count,
        root=[radius * math.cos(angle), 0.0, -radius * math.sin(angle) + 0.0],
        elements=elements_of(count),
        modes=MODES,
        radius=radius,
        cone=cone,
    )
    write_text(file, text)
    return file


def elements_of(stations: int) -> int:
    """Elements of a blade: equally many between its stations, an even number."""
    between = max(stations - 1, 1)
    return between * 2 * max(1, math.ceil(0.5 * ELEMENTS / between))
