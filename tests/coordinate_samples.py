"""A carriage on a rail and a wheel on an axle, for forces along their coordinates."""

from case_samples import rigid


class Raw(str):
    """Text of a value that is no word."""


CARRIAGE = (
    "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + '[joints.rail]\nkind = "prismatic"\nbetween = ["ground.O", "car.a"]\naxis = [1.0, 0.0, 0.0]\n'
    + '[signals.x]\nkind = "joint"\njoint = "rail"\ncoordinate = "z"\n'
    + '[signals.v]\nkind = "velocity"\nat = "car.a"\ncomponent = "x"\n'
)
WHEEL = (
    "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + '[joints.axle]\nkind = "revolute"\nbetween = ["ground.O", "wheel.a"]\n'
    + '[signals.angle]\nkind = "joint"\njoint = "axle"\ncoordinate = "angle"\n'
    + '[signals.w]\nkind = "angular_velocity"\nat = "wheel.a"\ncomponent = "z"\n'
)


def carriage(*forces: str, mass: float = 1.0, speed: float = 0.0) -> str:
    """A mass on a rail along x that starts at 0 with a speed."""
    return (
        CARRIAGE
        + rigid("car", mass, 0.1, {"a": (0, 0, 0)}, velocity=(speed, 0, 0))
        + "".join(forces)
    )


def wheel(*forces: str, inertia: float = 0.5, spin: float = 0.0) -> str:
    """An inertia about z that starts at 0 with a spin."""
    return (
        WHEEL
        + rigid("wheel", 2.0, inertia, {"a": (0, 0, 0)}, angular_velocity=(0, 0, spin))
        + "".join(forces)
    )


def force(name: str, kind: str, **keys) -> str:
    """`[forces.NAME]` of a kind."""
    quoted = [f'"{v}"' if type(v) is str else v for v in keys.values()]
    lines = [f"{key} = {value}" for key, value in zip(keys, quoted, strict=True)]
    return f'[forces.{name}]\nkind = "{kind}"\n' + "\n".join(lines) + "\n"
