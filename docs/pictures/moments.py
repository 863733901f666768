"""The controller of moments.toml: a proportional one by hand."""


def control(t, inputs, memory):
    """Return the moment [N m] towards an angle of 0.5 rad."""
    angle, _ = inputs
    return 2.0 * (0.5 - angle)
