"""Links of 0.1 m and 0.1 kg, axes of hinges turned about x by 0.3 rad each: motion in space."""

from math import cos, sin

LENGTH = 0.1


def case(name: str) -> str:
    """Text of the case of a scene chain-N."""
    count = int(name.split("-")[1])
    lines = ["format = 1", 'title = "chain"', "gravity = [0.0, -9.81, 0.0]", "[ground.hinge]"]
    lines += ["position = [0.0, 0.0, 0.0]"]
    for k in range(count):
        before = f"link-{k - 1}.tip" if k else "ground.hinge"
        tilt = 0.3 * (k % 3 - 1)
        lines += [
            f"[bodies.link-{k}]",
            'kind = "rigid"',
            "mass = 0.1",
            f"centre = [{LENGTH / 2}, 0.0, 0.0]",
            f"position = [{k * LENGTH}, 0.0, 0.0]",
            "inertia = [[1e-5, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]]",
            f"interfaces = {{ root = {{ position = [0.0, 0.0, 0.0] }}, "
            f"tip = {{ position = [{LENGTH}, 0.0, 0.0] }} }}",
            f"[joints.hinge-{k}]",
            'kind = "revolute"',
            f'between = ["{before}", "link-{k}.root"]',
            f"axis = [0.0, {sin(tilt)}, {cos(tilt)}]",
        ]
    return "\n".join([*lines, "[solver]", "t_end = 0.5", "output_step = 0.01", "[runs.base]", ""])
