"""A carriage on a rail and a wheel on an axle, for forces along their coordinates."""

from samples import case_samples
from samples.case_samples import rigid, run_text

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.run.preparation import prepare

RADAU = 'integrator = "radau"\nrtol = 1e-7\natol_position = 1e-9\natol_velocity = 1e-8'
DEFAULT = 'integrator = "radau"'


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
    """A mass on a rail along x that starts at 0 with a speed; its radius of gyration is 1 m."""
    return (
        CARRIAGE
        + rigid("car", mass, 2.0 * mass / 3.0, {"a": (0, 0, 0)}, velocity=(speed, 0, 0))
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


def run(folder, text, t_end, step, solver=""):
    """Signals and summary; by rk8 with tight tolerances unless `solver` says otherwise."""
    kept = case_samples.SOLVER
    if solver:
        head, _, tail = kept.partition("integrator")
        case_samples.SOLVER = head + solver + "\n{more}" + tail.partition("{more}")[2]
    try:
        return run_text(folder, text, t_end=t_end, step=step)
    finally:
        case_samples.SOLVER = kept


def prepared(folder, text):
    """Model and start of a case."""
    file = folder / "case.toml"
    file.write_text(
        case_samples.HEAD + text + case_samples.SOLVER.format(t_end=1.0, step=1.0, more="")
    )
    made = prepare(load_case(file).runs["base"], {})
    return made.model, made.y0
