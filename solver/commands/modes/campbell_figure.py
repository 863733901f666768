"""Figure of a Campbell diagram."""

from pathlib import Path

import numpy as np

from ...report.style import GREY, WARNING, Canvas, colour, house_style
from .campbell import RPM, Diagram


def draw(path: Path, diagram: Diagram) -> Path:
    """Draw campbell.png: frequencies of the branches over speed, harmonics and crossings."""
    c, hz = diagram.campbell, 2.0 * np.pi
    with house_style():
        canvas = Canvas(7.2, 4.8)
        (axes,) = canvas.panels(1)
        followed = diagram.campbell.followed(diagram.fixed) / hz
        top = 1.08 * float(np.nanmax(followed, initial=1e-3))
        for n in range(1, diagram.harmonics + 1):
            axes.plot(c.speeds, n * c.speeds / hz, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)))
            end = min(c.speeds[-1], top * hz / n)
            axes.annotate(
                f"{n}P", (end, n * end / hz), color=GREY, fontsize=8, va="bottom", ha="right"
            )
        for b, name in enumerate(diagram.names):
            axes.plot(c.speeds, followed[:, b], color=colour(b), label=name)
            grows = c.growth[:, b] > 0.0
            axes.plot(
                c.speeds[grows], followed[grows, b], ".", color=WARNING, markersize=4, zorder=4
            )
        points = [(x.speed, x.frequency / hz) for x in diagram.crossings if x.frequency / hz < top]
        if points:
            axes.plot(*zip(*points, strict=True), "o", color="black", markersize=3.5, zorder=5)
        axes.set_xlim(c.speeds[0], c.speeds[-1])
        axes.set_ylim(0.0, top)
        seen = "axes at rest" if diagram.fixed else "axes that turn"
        spec = diagram.spins.states.spec
        axes.set_title(f"{spec.case}, run {spec.run}: frequencies in {seen}")
        axes.set_xlabel("speed [rad/s]")
        axes.set_ylabel("frequency [Hz]")
        above = axes.secondary_xaxis("top", functions=(lambda w: w * RPM, lambda r: r / RPM))
        above.set_xlabel("speed [1/min]")
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
        return canvas.save(path)
