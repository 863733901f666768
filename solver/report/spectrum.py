"""The amplitude spectrum of one signal of several runs."""

from pathlib import Path

import numpy as np

from ..errors import InputError
from ..results.measures import spectrum
from .story import Comparison, Story
from .style import DASHES, Canvas, colour, unit_text

SMALLEST = 1e-4  # of the largest amplitude: the lower end of the picture


def draw_spectrum(path: Path, wanted: Comparison, stories: list[Story]) -> Path:
    """Draw amplitudes over frequency, a curve for each run.

    Raises
    ------
    InputError
        A signal with values that are not finite, or of too few output times.
    """
    canvas = Canvas(7.6, 4.0)
    (axes,) = canvas.panels(1)
    largest = 0.0
    for i, story in enumerate(stories):
        signal = story.signal(wanted.signal)
        try:
            frequency, amplitude = spectrum(story.result.t, signal.values)
        except ValueError as error:
            raise InputError(f"figures.{wanted.name}: run {story.name}: {error}") from error
        style = {"color": colour(i), "linestyle": DASHES[i % len(DASHES)]}
        axes.plot(frequency[1:], amplitude[1:], label=story.title, **style)
        largest = max(largest, float(np.max(amplitude[1:])))
    if largest > 0.0:
        axes.set_yscale("log")
        axes.set_ylim(SMALLEST * largest, 2.0 * largest)
    axes.set_title(wanted.title)
    axes.set_xlabel("frequency [Hz]")
    words = signal.description or signal.name
    axes.set_ylabel(f"amplitude: {words}{unit_text(signal.unit)}")
    canvas.figure.legend(loc="outside lower center", ncols=min(3, len(stories)))
    return canvas.save(path)
