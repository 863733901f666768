"""What held ends cost a beam: compliance that a solid or shell of the same part does not have."""

import numpy as np

from ..math.arrays import Array
from ..package import ModalPackage

# Saint-Venant's warping of F1, M2, M3 lies in the section, that of F2, F3, M1 along the beam: seen
# from the other end, one of the two has the other sign.
OTHER_END = np.array([1.0, -1.0, -1.0, -1.0, 1.0, 1.0])


def share_of_ends(package: ModalPackage, q: Array) -> float | None:
    """Return what both ends take from the strain energy, at most, over the largest energy.

    A beam whose end sections are held as rigid faces has F' S F / 2 less energy at each, with the
    resultants F there and S of the section (docs/format.md, end_compliance): so much less do its
    loads move, relative to what they do. Interfaces between the ends are left out.

    Parameters
    ----------
    q : (k, m) modal coordinates

    Returns
    -------
    None if the package does not have the data: not a uniform beam with an analysed section.
    """
    recovery = package.recovery
    if recovery is None or len(package.sections) != 1:
        return None
    S = package.sections[0].end_compliance
    if S is None:
        return None
    lost = np.zeros(len(q))
    for station, sign in ((0, np.ones(6)), (-1, OTHER_END)):
        F = q @ recovery.resultants_E[station].T * sign
        lost += np.einsum("ki,ij,kj->k", F, S, F)
    energy = np.einsum("ki,ij,kj->k", q, package.stiffness, q)
    largest = float(energy.max(initial=0.0))
    return float(min(1.0, max(0.0, lost.max(initial=0.0)) / largest)) if largest > 0.0 else 0.0


def held_lengths(package: ModalPackage) -> Array | None:
    """Return the length that a held end takes from a beam under the loads of each mode, (m,) [m].

    The sums of F' S F over those of F' K^-1 F along the beam, with its resultants F in the mode.
    None without the data, as in `share_of_ends`.
    """
    recovery = package.recovery
    if recovery is None or len(package.sections) != 1:
        return None
    section = package.sections[0]
    if section.end_compliance is None:
        return None
    F, C = recovery.resultants_E, np.linalg.inv(section.K)  # (s, 6, m)
    taken, whole = (np.einsum("sim,ij,sjm->m", F, A, F) for A in (section.end_compliance, C))
    return np.maximum(taken, 0.0) / np.maximum(whole, np.finfo(float).tiny)
