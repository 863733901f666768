"""Strain energy and exposure at the sites of a body: stations of a beam, cells of a shell.

The page and the files of the animation show them. Criteria are evaluated here only.
"""

from collections.abc import Iterator

import numpy as np

from ..math.arrays import Array, IntArray
from ..package.common.strengths import PlyStrength, YieldStrength
from ..results.view import Sites
from ..strength import criteria_of

SITES_AT_ONCE = 2_000_000  # numbers in memory at a time


def site_energy(sites: Sites, q: Array) -> Array:
    """Strain energy for unit length, area or volume, (k, s) [J/m, J/m2, J/m3], at q (k, m)."""
    F = np.einsum("sjm,km->ksj", sites.resultants_E, q, optimize=True)
    C = sites.compliance[sites.kind]
    return np.asarray(0.5 * np.einsum("ksi,sij,ksj->ks", F, C, F, optimize=True))


def site_exposure(sites: Sites, q: Array) -> Array:
    """Largest exposure 1/R of the governing points under all criteria, (k, s) [-].

    NaN where no ply has strengths.
    """
    found = np.full((len(q), len(sites.kind)), np.nan)
    for kind in range(len(sites.compliance)):
        own = np.flatnonzero(sites.kind == kind)
        points = np.flatnonzero(sites.point_kind == kind)
        if not len(points):
            continue
        some = max(1, SITES_AT_ONCE // (6 * len(points) * max(len(q), 1)))
        for first in range(0, len(own), some):
            rows = own[first : first + some]
            F = np.einsum("sjm,km->ksj", sites.resultants_E[rows], q, optimize=True)
            stress_M = np.einsum("pij,ksj->kspi", sites.stress_M[points], F, optimize=True)
            largest = np.zeros(F.shape[:2])
            for strength, same in _strengths(sites, points):
                for criterion in criteria_of(strength):
                    exposure = criterion.assess(stress_M[:, :, same], strength).exposure
                    np.maximum(largest, exposure.max(axis=2), out=largest)
            found[:, rows] = largest
    return found


def _strengths(
    sites: Sites, points: IntArray
) -> Iterator[tuple[PlyStrength | YieldStrength, IntArray]]:
    """Yield each strength with the places in `points` of the points that have it."""
    tables = [sites.plies[ply]["strength"] for ply in sites.point_ply[points].tolist()]
    for k, table in enumerate(tables):
        if table in tables[:k]:
            continue
        kind = YieldStrength if "yield_stress" in table else PlyStrength
        yield kind(**table), np.array([j for j, each in enumerate(tables) if each == table])
