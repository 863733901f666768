"""Coefficients of the backward differentiation formula on unequal steps.

Points are counted backwards from the new one in units of the new step h: the distance of
point i is s_i = (t_new - t_i) / h, so s_0 = 0 (new), s_1 = 1, s_2 > 1 ... All functions are
pure and loop over plain numbers.
"""

from collections.abc import Sequence


def predictor(s: Sequence[float]) -> list[float]:
    """Weights that extrapolate the polynomial through the past points s to the new one."""
    weights = []
    for i, s_i in enumerate(s):
        w = 1.0
        for j, s_j in enumerate(s):
            if j != i:
                w *= s_j / (s_j - s_i)
        weights.append(w)
    return weights


def corrector(s: Sequence[float]) -> tuple[float, list[float]]:
    """Derivative at the new point of the polynomial through it and the k past points s.

    Returns c_0 and b (k) with h y'(t_new) = c_0 (y_new - sum b_i y_i); sum b_i = 1.
    """
    c_0 = sum(1.0 / s_i for s_i in s)
    return c_0, [w / (s_i * c_0) for w, s_i in zip(predictor(s), s, strict=True)]


def error_weights(s: Sequence[float]) -> list[float]:
    """Weights on (new, past points s) of the local error of the formula of order len(s) - 1.

    The error is h times the defect of the formula in y' = f: the divided difference over all
    the points times the distances to the new point, the farthest left out, times h.
    """
    points = [0.0, *s]
    scale = 1.0
    for s_i in s[:-1]:
        scale *= s_i
    weights = []
    for i, s_i in enumerate(points):
        w = scale
        for j, s_j in enumerate(points):
            if j != i:
                w /= s_j - s_i
        weights.append(w)
    return weights


def interpolation(x: float, points: Sequence[float]) -> list[float]:
    """Weights of the polynomial through `points`, taken at x."""
    return predictor([p - x for p in points])
