"""Write the case file of N four-bar loops, or of a chain of N links.

    python cases/n-four-bar/generate.py four-bars 2 40 > cases/n-four-bar/case.toml
    python cases/n-four-bar/generate.py chain 10 > cases/chain-10/case.toml

Rods of 1 m and 1 kg, gravity -9.81 along y. `four-bars` writes the first number of loops into the
case and a run for each number; `chain` starts level, at rest, from one hinge.
"""

import sys
from collections.abc import Iterable

ROD = (
    'kind = "rigid", mass = 1.0, inertia = [[{0}, 0, 0], [0, {1}, 0], [0, 0, {2}]], '
    "centre = [{3}, {4}, 0], interfaces = {{ start = {{ position = [0, 0, 0] }}, "
    "end = {{ position = [{5}, {6}, 0] }} }}"
)
THIN, LONG = 6.7e-5, 1 / 12  # a square of 20 mm; a uniform rod, about its middle [kg m2]

FOUR_BARS = """\
# N four-bar mechanisms side by side: a benchmark of the IFToMM library of multibody problems (A02).
# Written by generate.py; `python cases/n-four-bar/generate.py four-bars {numbers}` writes it again.
#
# One degree of freedom, but N + 1 wherever all rods lie on one line, which each turn passes twice:
# there the constraint equations lose N of their ranks, and many a treatment its way.
#
# All joints are hinges in the plane. With 5 equations each, every loop would have 3 too many; the
# far end of each coupler is held on the axis of its hinge instead, by two (run n-2-hinges: as
# hinges, redundant).
#
# Larger numbers of loops run for 1 s, through the first singular position: the watch for singular
# positions and the checks at outputs are dense linear algebra, whose cost grows with the cube of N.
#
# Reference: uprights stay parallel, theta'' = -g cos(theta) (3 (N + 1) + 6 N) / (2 (N + 1) + 6 N).

format = 1
title = "N four-bar mechanisms with singular positions"
gravity = [0.0, -9.81, 0.0]"""
CHAIN = """\
# A chain of {n} rods in the plane. Written by cases/n-four-bar/generate.py.

format = 1
title = "Chain of {n} links"
gravity = [0.0, -9.81, 0.0]
"""


def rod(name: str, at: tuple[float, float], *, upright: bool, more: str = "") -> str:
    """One line: a rod from a point, along x or along y."""
    x, y = (0.0, 1.0) if upright else (1.0, 0.0)
    J = (LONG, THIN, LONG) if upright else (THIN, LONG, LONG)
    text = ROD.format(*(f"{j:.10g}" for j in J), 0.5 * x, 0.5 * y, x, y)
    return f"{name} = {{ {text}, position = [{at[0]:g}, {at[1]:g}, 0]{more} }}"


def joint(name: str, kind: str, one: str, two: str) -> str:
    """One line: a joint about or along z."""
    return f'{name} = {{ kind = "{kind}", between = ["{one}", "{two}"], axis = [0, 0, 1] }}'


def loops(first: int, last: int, prefix: str = "") -> Iterable[str]:
    """Tables of the loops first..last, counted from 1; loop 1 brings the first upright."""
    uprights = range(0 if first == 1 else first, last + 1)
    yield f"\n[{prefix}ground]"
    yield from (f"foot-{i} = {{ position = [{i}, 0, 0] }}" for i in uprights)
    yield f"\n[{prefix}bodies]"
    push = ", angular_velocity = [0, 0, -1]"
    for i in uprights:
        yield rod(f"upright-{i}", (i, 0), upright=True, more="" if i else push)
    yield from (rod(f"coupler-{i}", (i - 1, 1), upright=False) for i in range(first, last + 1))
    yield f"\n[{prefix}joints]"
    for i in uprights:
        yield joint(f"foot-{i}", "revolute", f"ground.foot-{i}", f"upright-{i}.start")
    for i in range(first, last + 1):
        yield joint(f"left-{i}", "revolute", f"upright-{i - 1}.end", f"coupler-{i}.start")
        yield joint(f"right-{i}", "point_on_line", f"upright-{i}.end", f"coupler-{i}.end")


def solver(t_end: float) -> Iterable[str]:
    """Lines of the solver's table."""
    yield f"\n[solver]\nt_end = {t_end:g}\noutput_step = 0.01"
    yield "rtol = 1e-6"


def position(body: str) -> Iterable[str]:
    """Signals of the end of a body."""
    for axis in "xy":
        yield f'\n[signals.{axis}]\nkind = "position"\nat = "{body}.end"\ncomponent = "{axis}"'


def four_bars(numbers: list[int]) -> Iterable[str]:
    """Lines of the case of so many loops, the smallest first."""
    base, *others = sorted(numbers)
    yield FOUR_BARS.format(numbers=" ".join(map(str, numbers)))
    yield from loops(1, base)
    yield from position("upright-0")
    yield '\n[signals.angle]\nkind = "joint"\njoint = "foot-0"\ncoordinate = "angle"'
    yield 'description = "turn of the first upright"'
    yield from solver(10.0)
    yield "\n[variants.hinges.joints]"
    yield from (f'right-{i}.kind = "revolute"' for i in range(1, base + 1))
    for n in others:
        yield from loops(base + 1, n, f"variants.n-{n}.")
        yield f"\n[variants.n-{n}.solver]\nt_end = 1"
    yield f'\n[runs.n-{base}]\ntitle = "N = {base}"'
    yield f'\n[runs.n-{base}-hinges]\ntitle = "N = {base}, redundant hinges"\nvariants = ["hinges"]'
    yield from (f'\n[runs.n-{n}]\ntitle = "N = {n}"\nvariants = ["n-{n}"]' for n in others)
    runs = ", ".join(f'"n-{n}"' for n in (base, *others))
    yield '\n[figures.turn]\ntitle = "Turn of the first upright"\nsignal = "angle"'
    yield f"runs = [{runs}]"
    yield "\n[coarse.solver]\nt_end = 0.1"


def chain(n: int) -> Iterable[str]:
    """Lines of the case of a chain of n links."""
    yield CHAIN.format(n=n)
    yield "[ground]\nhook = { position = [0, 0, 0] }\n\n[bodies]"
    yield from (rod(f"link-{i}", (i - 1, 0), upright=False) for i in range(1, n + 1))
    yield "\n[joints]"
    for i in range(1, n + 1):
        one = "ground.hook" if i == 1 else f"link-{i - 1}.end"
        yield joint(f"hinge-{i}", "revolute", one, f"link-{i}.start")
    yield from position(f"link-{n}")
    yield from solver(1.0)
    yield "\n[runs.base]"


if __name__ == "__main__":
    what, sizes = sys.argv[1], [int(word) for word in sys.argv[2:]]
    print("\n".join(four_bars(sizes) if what == "four-bars" else chain(*sizes)))
