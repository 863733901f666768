"""Controller that is a Python function of the user, called at instants."""

from .contract import Code, CoordinateForce, Expressions, Number, State, Terms

PYTHON_CONTROLLER = CoordinateForce(
    kind="python_controller",
    turns=False,
    meaning="a controller written in Python",
    remark="A run calls it only with the option `--allow-python`, because it can do whatever "
    "Python can. Its output is held between the instants t = 0, `sample_time`, ...",
    keys=(
        Code("code", "function(t, inputs, memory) of a Python file, which returns the force"),
        Expressions("inputs", "what the function gets as an array, in this order"),
        Number(
            "sample_time",
            "s",
            "between the instants at which it is called",
            required=True,
            above=0.0,
        ),
    ),
    terms=lambda values: Terms("held", states=(State("held", None, called=True),)),
    order=10,
)
