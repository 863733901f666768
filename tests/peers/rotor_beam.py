"""A shaft with a disc in two bearings by finite elements in axes at rest: Timoshenko's beam.

Unknowns of a node: displacements x y z and rotations about them. M q'' + (C + W G) q' + K q = f,
with the gyroscopic moments W I_p of sections and disc (H. D. Nelson, J. Mech. Des. 102 (1980) 793).
"""

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eig

ORDER = 7  # of the polynomials of an element
POINTS, WEIGHTS = legendre.leggauss(12)


def shapes():
    """Lagrange's polynomials on Chebyshev's points and their slopes at the points, (12, 8)."""
    nodes = -np.cos(np.pi * np.arange(ORDER + 1) / ORDER)
    inverse = np.linalg.inv(legendre.legvander(nodes, ORDER))
    slopes = legendre.legval(POINTS, legendre.legder(np.eye(ORDER + 1))).T
    return legendre.legvander(POINTS, ORDER) @ inverse, slopes @ inverse


def gyroscopic(polar):
    G = np.zeros((6, 6))
    G[4, 5], G[5, 4] = polar, -polar
    return G


class Rotor:
    """Two elements on either side of the disc at `place`.

    section : (6, 6) stiffness; mass : per length; inertia : polar and across, per length
    disc : mass, polar and transverse moment of inertia; bearings : (k, c) at both ends
    """

    def __init__(self, section, mass, inertia, length, place, disc, bearings):
        ends = np.array([0.0, place / 2, place, (place + length) / 2, length])
        n = 6 * (4 * ORDER + 1)
        self.K, self.M, self.G, self.C = np.zeros((4, n, n))
        N, D = shapes()
        m = np.diag([mass] * 3 + [inertia[0], inertia[1], inertia[1]])
        for e, half in enumerate(np.diff(ends) / 2):
            rows = slice(6 * e * ORDER, 6 * (e * ORDER + ORDER + 1))
            for weight, values, slopes in zip(WEIGHTS * half, N, D / half, strict=True):
                u, strain = np.kron(values, np.eye(6)), np.kron(slopes, np.eye(6))
                strain[1] -= u[5]
                strain[2] += u[4]
                self.K[rows, rows] += weight * strain.T @ section @ strain
                self.M[rows, rows] += weight * u.T @ m @ u
                self.G[rows, rows] += weight * u.T @ gyroscopic(inertia[0]) @ u
        self.disc, self.mass = 12 * ORDER, disc[0]
        rows = slice(self.disc, self.disc + 6)
        self.M[rows, rows] += np.diag([disc[0]] * 3 + [disc[1], disc[2], disc[2]])
        self.G[rows, rows] += gyroscopic(disc[1])
        for first, (k, c) in zip((0, n - 6), bearings, strict=True):
            for row in (first + 1, first + 2):
                self.K[row, row] += k
                self.C[row, row] += c
        self.K[0, 0] += 1e9
        self.K[3, 3] += 1.0  # so that nothing is free

    def whirls(self, speed):
        """Frequencies of the motions across the line, rising; each twice, to both sides."""
        n = len(self.M)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-self.K, -(self.C + speed * self.G)]])
        B = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), self.M]])
        values, vectors = eig(A, B)
        across = np.abs(vectors[[1, 2]]).max(axis=0) > np.abs(vectors[[0, 3]]).max(axis=0)
        return np.sort(values.imag[across & (values.imag > 1.0)])

    def orbit(self, speed, off):
        """Radius of the centre of a disc whose mass is `off` the line."""
        f = np.zeros(len(self.M), dtype=complex)
        f[self.disc + 1], f[self.disc + 2] = self.mass * off * speed**2 * np.array([1.0, -1.0j])
        q = np.linalg.solve(self.K - speed**2 * self.M + 1j * speed * (self.C + speed * self.G), f)
        return abs(q[self.disc + 1])
