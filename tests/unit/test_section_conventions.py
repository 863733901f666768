"""Other codes' order, signs and axes, each from its own field of displacements."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.report.section.codes import (
    BLADE_AXES_LEADING_EDGE,
    BLADE_AXES_TRAILING_EDGE,
    CODES,
    convert,
    transform,
)

FOLDER = Path(__file__).resolve().parents[1] / "reference" / "sections"
SECTIONS = ("11_iso_channel_chen2010", "14_aniso_tube_45", "21_box_layup2_30_0")


def reference(name):
    return tomllib.loads((FOLDER / f"{name}.toml").read_text())


def stiffness(name):
    return np.array(reference(name)["verified"]["K"])


def along_x1(P, s, g, k):
    """Plymotion and VABS: u1 = u + x3 f2 - x2 f3, u2 = v - x3 f1, u3 = w + x2 f1 at x1 = s."""
    _, x2, x3 = P
    u, f = s * g, s * k
    return np.array([u[0] + x3 * f[1] - x2 * f[2], u[1] - x3 * f[0], u[2] + x2 * f[0]])


def along_z(P, s, g, k):
    """BECAS, ANBA4, BeamDyn: ux = cx - y fz, uy = cy + x fz, uz = cz + y fx - x fy at z = s."""
    x, y, _ = P
    c, f = s * g, s * k
    return np.array([c[0] - y * f[2], c[1] + x * f[2], c[2] + y * f[0] - x * f[1]])


# Field of displacements of unit strains at s = 0, its beam axis, and where the code's axes point
# in ours, in words: the right edge of the drawn section is +x2, its upper edge +x3.
RIGHT, UP, OUT = np.eye(3)[1], np.eye(3)[2], np.eye(3)[0]
AS_DRAWN = {
    "plymotion": (along_x1, 0, (OUT, RIGHT, UP)),
    "vabs": (along_x1, 0, (OUT, RIGHT, UP)),
    "becas": (along_z, 2, (RIGHT, UP, OUT)),
    "anba4": (along_z, 2, (RIGHT, UP, OUT)),
    # airfoil coordinates: trailing edge right, suction side up; x to suction side, y to the
    # trailing edge, z = x cross y
    "beamdyn": (along_z, 2, (UP, RIGHT, -OUT)),
}


def strain_rows(code, points):
    """Tensor strain (p, 3, 3, 6) in the code's axes per unit of its six strains, s = 0."""
    field, along, _ = AS_DRAWN[code]
    step = 0.5
    out = np.empty((len(points), 3, 3, 6))
    for i, e in enumerate(np.eye(6)):
        for row, P in enumerate(points):

            def u(Q, e=e):
                return field(Q, Q[along], e[:3], e[3:])  # bilinear: differences are exact

            columns = [(u(P + step * d) - u(P - step * d)) / (2 * step) for d in np.eye(3)]
            gradient = np.stack(columns, axis=1)
            out[row, :, :, i] = (gradient + gradient.T) / 2
    return out


class Bars:
    """A beam of bars: each has stiffness for the strains 11, 12, 13 of its point, with coupling."""

    def __init__(self, seed=3, n=9):
        random = np.random.default_rng(seed)
        self.points = np.column_stack([np.zeros(n), random.uniform(-1, 1, (n, 2))])
        roots = random.standard_normal((n, 3, 3))
        self.stiffness = roots @ np.swapaxes(roots, 1, 2) + np.eye(3)
        self.mass = random.uniform(0.5, 2.0, n)

    def matrices(self, code, shift=(0.0, 0.0), angle=0.0):
        """K and M in a code's own axes, from the energy of its own field of displacements.

        The reference point and the section's axes are moved first, in space.
        """
        c, s = np.cos(angle), np.sin(angle)
        turned = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
        local = (self.points - [0.0, *shift]) @ turned.T  # seen from the new section axes
        field, _, axes = AS_DRAWN[code]
        A = np.stack(axes)
        points = local @ A.T
        strain = np.einsum("ba,pbci,cd->padi", A, strain_rows(code, points), A)
        strain = np.einsum("ba,pbci,cd->padi", turned, strain, turned)  # back to the bars' axes
        rows = np.stack([strain[:, 0, 0], 2 * strain[:, 0, 1], 2 * strain[:, 0, 2]], axis=1)
        K = np.einsum("pai,pab,pbj->ij", rows, self.stiffness, rows)
        # velocity of a moving section: its displacement after unit time
        velocity = np.array([[field(P, 1.0, e[:3], e[3:]) for e in np.eye(6)] for P in points])
        return K, np.einsum("pia,p,pja->ij", velocity, self.mass, velocity)


PLACES = [((0.0, 0.0), 0.0), ((0.3, -0.7), 0.0), ((0.0, 0.0), 0.6), ((-0.4, 1.1), -2.2)]


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize(("shift", "angle"), PLACES)
def test_matrices_are_those_of_the_codes_own_displacements(code, shift, angle):
    K, M = Bars().matrices("plymotion")
    K_code, M_code = Bars().matrices(code, shift, angle)
    for ours, theirs, kind in ((K, K_code, "stiffness"), (M, M_code, "mass")):
        found = convert(transform(ours, shift, angle, kind), code, kind)
        np.testing.assert_allclose(found, theirs, atol=1e-12 * np.abs(theirs).max())
        back = convert(theirs, "plymotion", kind, source=code)
        np.testing.assert_allclose(
            transform(back, kind=kind), transform(ours, shift, angle, kind), atol=1e-12
        )


def moved_in(code, K, shift):
    """K about a point (3,) in the code's axes, by fitting the strains of its field there."""
    _, along, _ = AS_DRAWN[code]
    random = np.random.default_rng(1)
    points = random.uniform(-1, 1, (12, 3))
    points[:, along] = 0.0
    old = strain_rows(code, points).reshape(-1, 6)
    new = strain_rows(code, points - shift).reshape(-1, 6)
    T, *_ = np.linalg.lstsq(old, new, rcond=None)  # old strains of unit new ones
    np.testing.assert_allclose(old @ T, new, atol=1e-12)
    return T.T @ K @ T


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("name", SECTIONS)
def test_moving_then_converting_is_converting_then_moving(code, name):
    K = transform(stiffness(name), (0.013, 0.004))  # box and tube are centred: bring in coupling
    shift = np.array([-0.021, 0.033])
    there = np.stack(AS_DRAWN[code][2]) @ np.array([0.0, *shift])
    scale = np.sqrt(np.outer(*[np.diag(convert(transform(K, shift), code))] * 2))
    moved = moved_in(code, convert(K, code), there)
    np.testing.assert_allclose(
        convert(transform(K, shift), code) / scale, moved / scale, atol=1e-10
    )


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("name", SECTIONS)
def test_turning_then_converting_is_converting_then_turning(code, name):
    K, angle = transform(stiffness(name), (0.013, 0.004)), 0.7
    _, along, axes = AS_DRAWN[code]
    # Turning the section axes by an angle about +x1 turns the code's axes about its own beam axis.
    sign = np.stack(axes)[along] @ OUT
    c, s = np.cos(sign * angle), np.sin(sign * angle)
    a, b = (along + 1) % 3, (along + 2) % 3
    R = np.eye(3)
    R[[a, a, b, b], [a, b, a, b]] = c, s, -s, c
    R6 = np.kron(np.eye(2), R)
    turned = R6 @ convert(K, code) @ R6.T
    scale = np.sqrt(np.outer(np.diag(turned), np.diag(turned)))
    np.testing.assert_allclose(
        convert(transform(K, rotation=angle), code) / scale, turned / scale, atol=1e-12
    )


@pytest.mark.parametrize("code", CODES)
def test_there_and_back_for_every_kind(code):
    random = np.random.default_rng(0)
    for kind in ("stiffness", "mass", "compliance", "resultants", "strains"):
        value = random.standard_normal((6, 6) if kind in ("stiffness", "mass", "compliance") else 6)
        there = convert(value, code, kind, blade_axes=BLADE_AXES_LEADING_EDGE)
        back = convert(there, "plymotion", kind, source=code, blade_axes=BLADE_AXES_LEADING_EDGE)
        np.testing.assert_array_equal(back, value)
        moved = transform(transform(value, (0.2, -0.3), 0.4, kind), (0, 0), -0.4, kind)
        np.testing.assert_allclose(transform(moved, (-0.2, 0.3), 0, kind), value, atol=1e-14)


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("axes", [BLADE_AXES_TRAILING_EDGE, BLADE_AXES_LEADING_EDGE])
def test_kinds_belong_together(code, axes):
    """F = K e, e = S F and the work F e stay true in every code and at every point."""
    K = stiffness("11_iso_channel_chen2010")
    e = np.array([1e-4, -2e-4, 3e-4, 0.1, -0.2, 0.3])
    changed = {}
    for kind, value in (
        ("stiffness", K),
        ("compliance", np.linalg.inv(K)),
        ("strains", e),
        ("resultants", K @ e),
    ):
        moved = transform(value, (0.01, 0.02), 0.3, kind)
        changed[kind] = convert(moved, code, kind, blade_axes=axes)
    F, e_new = changed["resultants"], changed["strains"]
    np.testing.assert_allclose(changed["stiffness"] @ e_new, F, rtol=1e-9)
    np.testing.assert_allclose(changed["compliance"] @ F, e_new, rtol=1e-9)
    assert F @ e_new == pytest.approx(e @ K @ e, rel=1e-12)


def test_resultants_of_a_beam_walked_backwards_change_sign():
    """Tension stays tension; a shear force and the moment on the face rotate with the face."""
    tension = convert([1, 0, 0, 0, 0, 0], "beamdyn", "resultants")
    np.testing.assert_array_equal(tension, [0, 0, 1, 0, 0, 0])
    up = convert([0, 0, 1, 0, 0, 0], "beamdyn", "resultants")
    np.testing.assert_array_equal(up, [-1, 0, 0, 0, 0, 0])
    twist = convert([0, 0, 0, 1, 0, 0], "beamdyn", "resultants")
    np.testing.assert_array_equal(twist, [0, 0, 0, 0, 0, 1])


@pytest.mark.parametrize(
    ("name", "tolerance", "entries"),
    [
        # BECAS names: N, Mx, My, T, Sx, Sy; its order Sx, Sy, N, Mx, My, T
        ("07_iso_half_tube_becas_c2", 2e-3, {"K_N_My": (2, 4), "K_Sy_T": (1, 5)}),
        ("08_iso_two_material_square_becas_s2", 1e-2, {"K_Sy_T": (1, 5), "K_N_My": (2, 4)}),
        ("09b_ortho_square_becas_s3_22.5", 1e-2, {"K_Sx_N": (0, 2), "K_Mx_T": (3, 5)}),
    ],
)
def test_numbers_that_becas_published(name, tolerance, entries):
    """Its meshes are coarse: the tolerance is the distance of the converged values from them."""
    published = reference(name)["published"]
    K = convert(stiffness(name), "becas")
    for key, place in entries.items():
        assert K[place] == pytest.approx(published[key], rel=tolerance), key
        assert K[place[::-1]] == K[place]
    EA, GA_2, GA_3, GJ, EI_2, EI_3 = published["diag_order_EA_GA2_GA3_GJ_EI2_EI3"]
    np.testing.assert_allclose(np.diag(K), [GA_2, GA_3, EA, EI_2, EI_3, GJ], rtol=1.5e-2)
    if "shear_centre" in published:
        S = np.linalg.inv(K)
        np.testing.assert_allclose(
            [-S[5, 1] / S[5, 5], S[5, 0] / S[5, 5]], published["shear_centre"], atol=1e-4
        )


def test_order_of_becas_is_that_of_its_own_comparison_with_vabs():
    """BECAS_VABS2BECASordering.m takes rows and columns 2, 3, 1, 5, 6, 4 of VABS."""
    K = np.arange(36.0).reshape(6, 6)
    rows = np.array([2, 3, 1, 5, 6, 4]) - 1
    np.testing.assert_array_equal(convert(K, "becas", source="vabs"), K[np.ix_(rows, rows)])


def test_numbers_that_anba4_published():
    square = reference("02_iso_square_anba4")
    EA, GA_2, GA_3, GJ, EI_2, EI_3 = square["published"]["diag_order_EA_GA2_GA3_GJ_EI2_EI3"]
    K = convert(stiffness("02_iso_square_anba4"), "anba4")
    np.testing.assert_allclose(np.diag(K), [GA_2, GA_3, EA, EI_2, EI_3, GJ], rtol=2e-4)


def test_coupled_section_of_anba4_in_our_signs():
    """A C section about the back of its web: first moments and inertia in closed form."""
    published = reference("anba4_c_section")["published"]
    K = convert(published["K"], "plymotion", source="anba4")
    M = convert(published["M"], "plymotion", "mass", source="anba4")
    parts = [(0.1, 2.0, 0.05, 0.0), (0.9, 0.1, 0.55, 0.95), (0.9, 0.1, 0.55, -0.95)]
    A = sum(b * h for b, h, _, _ in parts)
    first = sum(b * h * y for b, h, y, _ in parts)
    I2 = sum(b * h**3 / 12 + b * h * z**2 for b, h, _, z in parts)
    I3 = sum(h * b**3 / 12 + b * h * y**2 for b, h, y, _ in parts)
    assert K[0, 0] == pytest.approx(A, rel=1e-9)
    assert K[0, 5] == pytest.approx(-first, rel=1e-9)  # F1 = -int E x2 kappa3
    assert K[4, 4] == pytest.approx(I2, rel=1e-9)
    assert K[5, 5] == pytest.approx(I3, rel=1e-9)
    assert M[2, 3] == pytest.approx(first, rel=1e-9)  # v3 = omega1 x2
    assert M[0, 5] == pytest.approx(-first, rel=1e-9)
    assert M[3, 3] == pytest.approx(I2 + I3, rel=1e-9)
    # its own formula for the shear centre, and ours
    theirs = np.array(published["K"])
    Y = np.linalg.solve(theirs[:3, :3], -theirs[:3, 3:])
    S = np.linalg.inv(K)
    ours = [-S[3, 2] / S[3, 3], S[3, 1] / S[3, 3]]
    np.testing.assert_allclose(ours, [-Y[1, 2], Y[0, 2]], rtol=1e-6)
    assert ours[0] < -0.25, "the shear centre lies behind the web"


def test_vabs_is_ours():
    """PreVABS + VABS print the channel's couplings with the signs that we have."""
    published = np.array(reference("11_iso_channel_chen2010")["published"]["K_prevabs"])
    K = convert(stiffness("11_iso_channel_chen2010"), "vabs")
    scale = np.sqrt(np.outer(np.diag(K), np.diag(K)))
    np.testing.assert_allclose(K / scale, published / scale, atol=7e-3)
    assert np.all(np.sign(K[published != 0]) == np.sign(published[published != 0]))


def test_mass_in_blade_axes_has_the_form_of_the_beamdyn_manual():
    """Equation (Mass) of its user manual: m, X_cm, Y_cm of the local blade axes."""
    m, x2, x3 = 3.0, 0.4, 0.1  # towards trailing edge, towards suction side
    ours = transform(np.diag([m, m, m, 0.9, 0.2, 0.7]), (-x2, -x3), kind="mass")
    X, Y = x3, x2
    M = convert(ours, "beamdyn", "mass")
    i_edge, i_flap, i_cp = 0.7 + m * Y**2, 0.2 + m * X**2, m * X * Y
    manual = [
        [m, 0, 0, 0, 0, -m * Y],
        [0, m, 0, 0, 0, m * X],
        [0, 0, m, m * Y, -m * X, 0],
        [0, 0, m * Y, i_edge, -i_cp, 0],
        [0, 0, -m * X, -i_cp, i_flap, 0],
        [-m * Y, m * X, 0, 0, 0, i_edge + i_flap],
    ]
    np.testing.assert_allclose(M, manual, atol=1e-15)


def test_blade_axes_of_a_section_drawn_to_the_leading_edge():
    """The rotation that SONATA applies to results of VABS and ANBA4 for BeamDyn."""
    K = stiffness("11_iso_channel_chen2010")
    B = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]])
    B6 = np.kron(np.eye(2), B)
    np.testing.assert_allclose(
        convert(K, "beamdyn", blade_axes=BLADE_AXES_LEADING_EDGE), B6 @ K @ B6.T, rtol=1e-14
    )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: convert(np.eye(6), "bekas"), ["code = 'bekas'", "did you mean 'becas'"]),
        (lambda: convert(np.eye(6), "vabs", source="nabsa"), ["'nabsa'", "plymotion, vabs"]),
        (lambda: convert(np.eye(6), "vabs", "stiffnes"), ["did you mean 'stiffness'"]),
        (lambda: convert(np.eye(4), "vabs"), ["stiffness: expected shape (6, 6), got (4, 4)"]),
        (lambda: convert(np.eye(6), "vabs", "resultants"), ["expected shape (6,)"]),
        (lambda: transform(np.eye(6), (1.0, 2.0, 3.0)), ["translation", "x2 and x3"]),
        (lambda: convert(np.eye(6), "beamdyn", blade_axes=2 * np.eye(3)), ["rotation (3, 3)"]),
        (
            lambda: convert(np.eye(6), "beamdyn", blade_axes=((0, 0, 1), (0, 1, 0), (1, 0, 0))),
            ["right-handed"],
        ),
        (lambda: convert(np.eye(6), "beamdyn", blade_axes=np.eye(3)), ["z along the beam"]),
    ],
)
def test_wrong_requests_are_explained(call, words):
    with pytest.raises(InputError) as caught:
        call()
    for word in words:
        assert word in str(caught.value)
