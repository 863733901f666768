"""Root mean square and spectrum of signals against closed forms."""

import numpy as np
import pytest

from plymotion.solver.results.summary import SquareIntegral, spectrum


def _rms(t, values, *cuts):
    integral = SquareIntegral()
    for block in np.split(np.arange(len(t)), cuts):
        integral.take(t[block], values[block])
    return integral.rms()


def test_rms_of_a_sine_and_a_line():
    t = np.linspace(0.0, 1.0, 2001)
    assert _rms(t, 3.0 * np.sin(2 * np.pi * 5 * t)) == pytest.approx(3.0 / np.sqrt(2.0), rel=1e-12)
    assert _rms(t, t) == pytest.approx(np.sqrt(1.0 / 3.0), rel=1e-6)


def test_rms_counts_time_not_samples():
    t = np.array([0.0, 1.0, 1.001, 1.002, 1.003])
    assert _rms(t, np.full(5, -2.0)) == pytest.approx(2.0, rel=1e-14)
    one = np.array([1.0, 1.0, 0.0, 0.0, 0.0])
    assert _rms(t, one) == pytest.approx(np.sqrt(1.0005 / 1.003), rel=1e-12)


def test_rms_by_blocks_and_with_gaps():
    t = np.linspace(0.0, 2.0, 31) ** 2
    values = np.cos(t)
    assert _rms(t, values, 1, 7, 30) == pytest.approx(_rms(t, values), rel=1e-14)
    values[10:] = np.inf
    assert _rms(t, values, 12) == pytest.approx(_rms(t[:10], values[:10]), rel=1e-14)
    assert _rms(t[:1], np.array([-4.0])) == 4.0
    assert _rms(t[:2], np.full(2, np.nan)) is None


@pytest.mark.parametrize("n", [400, 401])
@pytest.mark.parametrize("window", ["hann", "none"])
def test_spectrum_has_the_amplitudes_of_its_sines(n, window):
    t = np.arange(n) * 0.005
    length = n * 0.005
    f1, f2 = 12 / length, 50 / length
    values = 7.0 + 2.0 * np.sin(2 * np.pi * f1 * t) + 0.5 * np.cos(2 * np.pi * f2 * t)
    f, amplitude = spectrum(t, values, window)
    assert f[12] == pytest.approx(f1, rel=1e-12)
    assert amplitude[12] == pytest.approx(2.0, rel=1e-12)
    assert amplitude[50] == pytest.approx(0.5, rel=1e-12)
    away = np.ones(len(f), dtype=bool)
    away[[11, 12, 13, 49, 50, 51]] = False
    assert amplitude[away].max() < 1e-12


def test_spectrum_leaves_out_a_short_last_interval_and_refuses_the_rest():
    t = np.append(np.arange(64) / 64, 1.001 - 1 / 128)
    f, amplitude = spectrum(t, np.append(np.cos(2 * np.pi * 8 * t[:-1]), 99.0))
    assert f[8] == pytest.approx(8.0)
    assert amplitude[8] == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(ValueError, match="equal distances"):
        spectrum(np.array([0.0, 1.0, 3.0, 4.0, 5.0]), np.zeros(5))
    with pytest.raises(ValueError, match="four output times"):
        spectrum(t[:3], np.zeros(3))
    with pytest.raises(ValueError, match="finite"):
        spectrum(t[:8], np.full(8, np.nan))
    with pytest.raises(ValueError, match="hann"):
        spectrum(t[:8], np.zeros(8), "hamming")
