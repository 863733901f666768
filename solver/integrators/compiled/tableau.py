"""Coefficients of Radau IIA with three stages, order 5 (Hairer and Wanner, section IV.8)."""

import numpy as np

ROOT = np.sqrt(6.0)
C = np.array([(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0])  # stages [h]
# Powers of a collocation polynomial that vanishes at 0, from its values at C: c_k of x^(k+1).
POWERS = np.linalg.inv(np.column_stack([C, C**2, C**3]))
# Stage equations z = h A f: A integrates the polynomial through f at C.
A = np.column_stack([C, C**2 / 2.0, C**3 / 3.0]) @ np.linalg.inv(np.vander(C, 3, increasing=True))
A_INVERSE = np.linalg.inv(A)


def _real_form() -> tuple[float, complex, np.ndarray, np.ndarray]:
    """Return mu, nu, T, T^-1 with T^-1 A^-1 T = [mu; Re nu, -Im nu; Im nu, Re nu]."""
    values, vectors = np.linalg.eig(np.linalg.inv(A))
    real = int(np.argmin(np.abs(values.imag)))
    pair = int(np.argmin(values.imag))
    T = np.column_stack([vectors[:, real].real, vectors[:, pair].real, vectors[:, pair].imag])
    # A^-1 (u + i v) = nu' (u + i v): w_1 + i w_2 is multiplied by the conjugate of nu'
    return float(values[real].real), complex(values[pair].conjugate()), T, np.linalg.inv(T)


MU, NU, T, T_INVERSE = _real_form()
# Embedded formula of order 3, times 1 / h: f_0 + ERROR z / h, then divided by mu / h - J.
ERROR = np.array([-13.0 - 7.0 * ROOT, -13.0 + 7.0 * ROOT, -1.0]) / 3.0
