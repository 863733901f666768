"""Figures with `spectrum` or `against`: amplitudes over frequency, one signal over another."""

import dataclasses

import numpy as np
import pytest
from samples.result_samples import swinging_rod

from plymotion.solver.errors import InputError
from plymotion.solver.report.case_figures import draw_comparison, draw_orbit, draw_spectrum
from plymotion.solver.report.report_data import Comparison, Story, comparisons
from plymotion.solver.report.style import Canvas, house_style
from plymotion.solver.results import Signal


def _story(values):
    result = swinging_rod()
    signal = Signal("hum", "m", "humming", values(result.t))
    return Story("rod", "Rod", {"completed": True}, dataclasses.replace(result, signals=(signal,)))


def test_curve_has_the_amplitude_at_the_frequency(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(Canvas, "save", lambda canvas, path: drawn.append(canvas) or path)
    story = _story(lambda t: 3.0 + 0.25 * np.sin(2 * np.pi * 7 * t * (len(t) - 1) / len(t) / t[-1]))
    with house_style():
        draw_spectrum(tmp_path / "f.png", Comparison("f", "F", "hum", ("rod",), True), [story])
    (axes,) = drawn[0].figure.axes
    (line,) = axes.lines
    amplitude = line.get_ydata()
    assert np.argmax(amplitude) == 6  # without the mean
    assert amplitude[6] == pytest.approx(0.25, rel=1e-9)
    assert axes.get_xlabel() == "frequency [Hz]"
    assert axes.get_ylabel() == "amplitude: humming [m]"


def test_a_signal_without_values_is_named(tmp_path):
    wanted = Comparison("f", "F", "hum", ("rod",), True)
    with house_style(), pytest.raises(InputError, match=r"figures\.f: run rod: .*finite"):
        draw_spectrum(tmp_path / "f.png", wanted, [_story(lambda t: np.full(len(t), np.inf))])


def test_an_orbit_is_one_signal_against_another(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(Canvas, "save", lambda canvas, path: drawn.append(canvas) or path)
    story = _story(lambda t: np.sin(t))
    across = Signal("swing", "m", "across", np.cos(story.result.t))
    signals = (*story.result.signals, across)
    story = dataclasses.replace(story, result=dataclasses.replace(story.result, signals=signals))
    wanted = Comparison("o", "Orbit", "hum", ("rod",), against="swing")
    with house_style():
        draw_orbit(tmp_path / "o.png", wanted, [story])
    (axes,) = drawn[0].figure.axes
    np.testing.assert_allclose(np.hypot(*axes.lines[0].get_data()), 1.0)
    assert axes.get_xlabel() == "across [m]"
    assert axes.get_aspect() == 1.0


RATIO: dict[str, object] = {"signals": {"hum": {"kind": "strength_ratio"}}}


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("often", [1, 40])
def test_the_smallest_strength_ratio_is_marked_and_infinite_ones_are_gaps(
    tmp_path, monkeypatch, often
):
    """With curves that cross often each run has its panel; one without stress has none."""
    drawn = []
    monkeypatch.setattr(Canvas, "save", lambda canvas, path: drawn.append(canvas) or path)

    def ratio(phase):
        def values(t):
            found = 10.0 ** (2.0 + np.cos(2 * np.pi * often * t / t[-1] + phase))
            found[0] = np.inf
            return found

        return values

    stories = [
        _story(values) for values in (ratio(0.0), ratio(1.0), lambda t: np.full(len(t), np.inf))
    ]
    stories = [
        dataclasses.replace(story, name=name, title=name, inputs=RATIO)
        for name, story in zip(("soft", "stiff", "rigid"), stories, strict=True)
    ]
    (wanted,) = comparisons({}, stories)
    with house_style():
        draw_comparison(tmp_path / "r.png", wanted, stories)
        draw_comparison(tmp_path / "n.png", wanted, stories[2:])
    figure = drawn[0].figure
    assert len(figure.axes) == (1 if often == 1 else 2)
    for axes in figure.axes:
        assert axes.get_yscale() == "log"
        assert 1.0 < axes.get_ylim()[0] < 10.1
    circles = [line for axes in figure.axes for line in axes.lines if line.get_marker() == "o"]
    smallest = [np.min(story.signal("hum").values) for story in stories[:2]]
    assert [circle.get_ydata()[0] for circle in circles] == smallest
    if often == 1:
        words = [text.get_text() for text in figure.legends[0].get_texts()]
        assert words[0] == "soft, smallest 10 at 1.000 s"
        assert words[2] == "rigid: no stress"
    else:
        assert [axes.get_title("left") for axes in figure.axes] == ["soft", "stiff"]
        assert figure.get_supxlabel().endswith("rigid: no stress")
    assert drawn[1].figure.legends[0].get_texts()[0].get_text() == "rigid: no stress"


def test_logarithmic_axes_have_numbers(tmp_path):
    """Not the text of formulas, which `house_style` does not typeset."""
    with house_style():
        canvas = Canvas(4.0, 3.0)
        (axes,) = canvas.panels(1)
        axes.loglog([1e-3, 1e2], [1e-9, 1.0])
        canvas.save(tmp_path / "log.png")
        labels = [t.get_text() for t in (*axes.get_xticklabels(), *axes.get_yticklabels())]
    assert [float(text.replace("\N{MINUS SIGN}", "-")) for text in labels if text]
