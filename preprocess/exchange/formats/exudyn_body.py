"""A modal package as a reduced-order body of Exudyn (ObjectFFRFreducedOrder).

Needs exudyn, numpy and h5py. From the inertia invariants of the package alone, Exudyn's matrices
are contractions (docs/exchange.md); no mass matrix of the FE model is needed.

    import arm_exudyn
    body = arm_exudyn.add_body(mbs)
    arm_exudyn.add_weight(mbs, body, [0.0, 0.0, -9.81])
    tip = arm_exudyn.add_marker(mbs, body, "tip")
"""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

FILE = Path(__file__).parent / "PACKAGE"
a, b, c = np.ogrid[:3, :3, :3]
EPS = (a - b) * (b - c) * (c - a) / 2.0


def skew(v: Any) -> Any:
    """Matrix of v x."""
    return -np.einsum("abc,c->ab", EPS, v)


def read(file: Path = FILE) -> dict[str, np.ndarray]:
    """Datasets of the package by path."""
    datasets = {}

    def visit(path: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            datasets[path] = item[()]

    with h5py.File(file) as h5:
        h5["modal_package"].visititems(visit)
    return datasets


AROUND = np.concatenate([np.eye(3), -np.eye(3)])  # ways to nodes about an interface, over ARM
ARM = 0.01  # of the size of the body


def interfaces(p: dict[str, np.ndarray]) -> list[str]:
    """Names of the interfaces, in the order of their nodes."""
    return sorted({path.split("/")[1] for path in p if path.startswith("interfaces/")})


def nodes(p: dict[str, np.ndarray]) -> tuple[Any, Any]:
    """Positions (n, 3) and shapes (m, n, 3) of the nodes of the mesh and of added ones.

    The mass centre follows them: on it weight does the work of the invariants. Then six nodes about
    each interface, which move with its translation and rotation.
    """
    x, shapes = [p["mesh/nodes_B"]], [p["modes/shapes_B"][:, :, :3]]
    mass = p["invariants/mass"]
    x.append(p["invariants/S0_B"][None, :] / mass)
    shapes.append(p["invariants/S_B"].T[:, None, :] / mass)
    way = ARM * float(np.ptp(x[0], axis=0).max()) * AROUND
    for name in interfaces(p):
        place = p[f"interfaces/{name}/position_B"]
        phi, psi = (p[f"interfaces/{name}/{of}_B"].T[:, None, :] for of in ("phi", "psi"))
        x.append(place + way)
        shapes.append(phi + np.cross(psi, way))
    return np.concatenate(x), np.concatenate(shapes, axis=1)


def exudyn_data(p: dict[str, np.ndarray]) -> dict[str, object]:
    """The dictionary of exudyn.FEM.ObjectFFRFreducedOrderInterface, from the datasets of `read`."""
    mass, S0, S = (p["invariants/" + name] for name in ("mass", "S0_B", "S_B"))
    T00, T01, T11 = (p["invariants/" + name] for name in ("T00_B", "T01_B", "T11_B"))
    x, shapes = nodes(p)
    m, n, one = S.shape[1], len(x), np.eye(3)
    return {
        "modeBasis": shapes.reshape(m, 3 * n).T.copy(),
        "trigList": [],
        "postProcessingModes": {},
        "massMatrixReduced": p["modes/mass"],
        "stiffnessMatrixReduced": p["modes/stiffness"],
        "infoList": [m, n, 3, 4, 7, 7 + m],
        "rigidBodyNodeType": "NodeType.RotationEulerParameters",
        "xRef": x.ravel(),
        "Mtt": mass * one,
        "totalMass": float(mass),
        "chiU": S0 / mass,
        "chiUtilde": skew(S0 / mass),
        "inertiaLocal": np.trace(T00) * one - T00 + p["invariants/J0_B"],
        "mPhitTPsi": S,
        "mPhitTPsiTilde": np.hstack([skew(S[:, i]) for i in range(m)]),
        "mXRefTildePsi": -np.einsum("abc,bci->ai", EPS, T01) - p["invariants/J_psi_B"],
        "mPsiTildePsi": -np.einsum("abc,bcij->iaj", EPS, T11).reshape(3 * m, m),
        "mXRefTildePsiTilde": np.hstack(
            [np.trace(T01[..., i]) * one - T01[..., i].T for i in range(m)]
        ),
        "mPsiTildePsiTilde": np.block(
            [
                [np.trace(T11[..., i, j]) * one - T11[..., i, j].T for j in range(m)]
                for i in range(m)
            ]
        ),
    }


def add_body(mbs: Any, file: Path = FILE, **options: Any) -> dict[str, Any]:
    """Add the body; return Exudyn's numbers of its objects, and "package" with the datasets.

    Parameters
    ----------
    mbs : system of Exudyn
    file : the package
    options : of AddObjectFFRFreducedOrder of Exudyn, such as positionRef
    """
    import exudyn
    from exudyn.FEM import ObjectFFRFreducedOrderInterface

    p = read(file)
    body = ObjectFFRFreducedOrderInterface()
    body.SetWithDictionary(exudyn_data(p))
    m = len(p["modes/mass"])
    body.massMatrixFFRFreduced = np.zeros((7 + m, 7 + m))
    objects = body.AddObjectFFRFreducedOrder(mbs, **options)
    damping = exudyn.MatrixContainer()
    damping.SetWithDenseMatrix(p["modes/damping"], useDenseMatrix=True)
    mbs.SetObjectParameter(objects["oFFRFreducedOrder"], "dampingMatrixReduced", damping)
    return {**objects, "package": p}


def add_weight(mbs: Any, body: dict[str, Any], gravity: Any) -> Any:
    """Add the weight as a load on the mass centre, which moves with the modes.

    Parameters
    ----------
    mbs : system of Exudyn
    body : as of `add_body`
    gravity : acceleration, global axes [m/s2]
    """
    from exudyn.itemInterface import Force, MarkerSuperElementPosition

    p = body["package"]
    marker = mbs.AddMarker(
        MarkerSuperElementPosition(
            bodyNumber=body["oFFRFreducedOrder"],
            meshNodeNumbers=[len(p["mesh/nodes_B"])],
            weightingFactors=[1.0],
        )
    )
    force = float(p["invariants/mass"]) * np.asarray(gravity, dtype=float)
    return mbs.AddLoad(Force(markerNumber=marker, loadVector=force))


def add_marker(mbs: Any, body: dict[str, Any], interface: str) -> Any:
    """Add a marker of position and rotation at an interface, for any joint; return its number.

    Parameters
    ----------
    mbs : system of Exudyn
    body : as of `add_body`
    interface : its name
    """
    from exudyn.itemInterface import MarkerSuperElementRigid

    p = body["package"]
    first = len(p["mesh/nodes_B"]) + 1 + len(AROUND) * interfaces(p).index(interface)
    return mbs.AddMarker(
        MarkerSuperElementRigid(
            bodyNumber=body["oFFRFreducedOrder"],
            meshNodeNumbers=[first + k for k in range(len(AROUND))],
            weightingFactors=[1.0 / len(AROUND)] * len(AROUND),
        )
    )
