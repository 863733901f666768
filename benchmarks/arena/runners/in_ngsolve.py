"""NGSolve: sections by elements of degree 2 to 7 on our coarse cells; the beam theory is here.

Giavotto's central solutions: warping g and strains psi = Y theta under a unit resultant theta, with
theta' = T theta: E g + R psi = (C' - C) g' + L psi', R' g + A psi = theta - L' g'. NGSolve has
forms and elements of any degree, no sections of beams; the equations are solved by SuperLU.
"""

from typing import Any

import numpy as np
from common import Sheet, Timed, main

NAME = "NGSolve"
ENVIRONMENT: dict[str, Any] = {"pip": ["ngsolve==6.2.2608", "numpy", "scipy"]}
NAMES = ("EA", "GA2", "GA3", "GJ", "EI2", "EI3")


def cannot(sheet: Sheet) -> str:
    """Sections of straight walls with a ply or more than one cell through each ply."""
    if sheet["kind"] != "section":
        return "a finite-element code: sections here"
    return "" if sheet["cells"] else "curved cells, or several plies in a cell: not in this runner"


def settings(sheet: Sheet) -> list[Sheet]:
    """Degrees."""
    return [{"method": "central solutions", "degree": p} for p in (2, 3, 4, 5, 6)]


def meshed(nodes: Any, cells: Any) -> Any:
    """A mesh of our quadrilaterals."""
    import netgen.meshing as ng
    import ngsolve

    mesh = ng.Mesh(dim=2)
    points = [mesh.Add(ng.MeshPoint(ng.Pnt(x, y, 0.0))) for x, y in nodes]
    face = mesh.Add(ng.FaceDescriptor(bc=1, domin=1, surfnr=1))
    for cell in cells:
        mesh.Add(ng.Element2D(face, [points[k] for k in cell]))
    return ngsolve.Mesh(mesh)


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Assemble, six central solutions, invert the compliance."""
    from ngsolve import (
        H1,
        L2,
        BilinearForm,
        CoefficientFunction,
        FESpace,
        GridFunction,
        InnerProduct,
        Integrate,
        LinearForm,
        dx,
        grad,
        x,
        y,
    )
    from scipy.sparse import csc_matrix, csr_matrix
    from scipy.sparse.linalg import splu

    with np.load(sheet["cells"]) as file:
        nodes, cells, stiffness = file["nodes"], file["cells"], file["C"]
    with Timed() as used:
        size = float(np.ptp(nodes))  # lengths over the size, stiffness over its largest entry
        top = float(stiffness.max())
        mesh = meshed(nodes / size, cells)
        held = GridFunction(L2(mesh, order=0, dim=36))
        held.vec.FV().NumPy()[:] = (stiffness / top).ravel()
        C = CoefficientFunction(tuple(held), dims=(6, 6))
        space = FESpace([H1(mesh, order=setting["degree"])] * 3)
        u, v = space.TnT()

        def across(w: Any) -> Any:  # B w: 11, 22, 33, 23, 13, 12
            a, b, c = (grad(part) for part in w)
            return CoefficientFunction((0.0, b[0], c[1], b[1] + c[0], a[1], a[0]))

        def along(w: Any) -> Any:  # S w
            return CoefficientFunction((w[0], 0.0, 0.0, 0.0, w[2], w[1]))

        def matrix(form: Any) -> Any:
            made = BilinearForm(space, symmetric=False)
            made += form * dx
            made.Assemble()
            values, columns, rows = (np.array(part) for part in made.mat.CSR())
            return csr_matrix((values, columns, rows))

        def columns(operator: Any, strains: Any) -> Any:
            found = []
            for z in strains:
                form = LinearForm(space)
                form += InnerProduct(operator(v), C * z) * dx
                form.Assemble()
                found.append(form.vec.FV().NumPy().copy())
            return np.array(found).T

        def strain(*rows: Any) -> Any:
            return CoefficientFunction(rows)

        Z = [
            strain(1.0, 0, 0, 0, 0, 0), strain(0, 0, 0, 0, 0, 1.0), strain(0, 0, 0, 0, 1.0, 0),
            strain(0, 0, 0, 0, x, -y), strain(y, 0, 0, 0, 0, 0), strain(-x, 0, 0, 0, 0, 0),
        ]  # fmt: skip
        E = matrix(InnerProduct(across(v), C * across(u)))
        G = matrix(InnerProduct(across(v), C * along(u)))
        M = matrix(InnerProduct(along(v), C * along(u)))
        R, L = columns(across, Z), columns(along, Z)
        A = np.array([[Integrate(InnerProduct(a, C * b), mesh) for b in Z] for a in Z])
        # rigid motions: a corner, a component of the farthest one, and no mean shear
        n, corners = R.shape[0], nodes / size
        part, far = n // 3, int(np.argmax(np.linalg.norm(corners - corners[0], axis=1)))
        across_x = abs(corners[far, 0] - corners[0, 0]) > abs(corners[far, 1] - corners[0, 1])
        pinned = [0, part, 2 * part, (2 if across_x else 1) * part + far]
        free, some = np.setdiff1d(np.arange(n), pinned), [0, 3, 4, 5]
        options = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
        factors = splu(csc_matrix(E[free][:, free]), diag_pivot_thresh=0.0, **options)
        soft = factors.solve(R[free][:, some])
        S = A[np.ix_(some, some)] - R[free][:, some].T @ soft

        def central(f: Any, theta: Any) -> tuple[Any, Any]:
            """Warping and strains of E X + R Y = f, R' X + A Y = theta."""
            X, Y, own = np.zeros((n, 6)), np.zeros((6, 6)), factors.solve(f[free])
            Y[some] = np.linalg.solve(S, theta[some] - R[free][:, some].T @ own)
            X[free] = own - soft @ Y[some]
            return X, Y

        T = np.zeros((6, 6))
        T[4, 2], T[5, 1] = 1.0, -1.0
        X, Y = central(np.zeros((n, 6)), np.eye(6))
        XT, YT = X @ T, Y @ T
        X, Y = central((G.T - G) @ XT + L @ YT, np.eye(6) - L.T @ XT)
        F = X.T @ (E @ X) + XT.T @ (M @ XT) + Y.T @ A @ Y
        for part in (X.T @ (G @ XT), X.T @ R @ Y, XT.T @ L @ Y):
            F = F + part + part.T
        K = np.linalg.inv(F)
    powers = np.array([size] * 3 + [size**2] * 3)
    K = K * top * np.outer(powers, powers)
    return {name: float(K[k, k]) for k, name in enumerate(NAMES) if name in sheet["values"]}, (
        used.seconds
    )


if __name__ == "__main__":
    main(solve)
