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


def read(file: Path = FILE) -> dict[str, Any]:
    """Datasets of the package by path."""
    found = {}

    def visit(path: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            found[path] = item[()]

    with h5py.File(file) as h5:
        h5["modal_package"].visititems(visit)
    return found


def exudyn_data(p: dict[str, Any]) -> dict[str, Any]:
    """The dictionary of exudyn.FEM.ObjectFFRFreducedOrderInterface, from the datasets of `read`."""
    mass, S0, S = (p["invariants/" + name] for name in ("mass", "S0_B", "S_B"))
    T00, T01, T11 = (p["invariants/" + name] for name in ("T00_B", "T01_B", "T11_B"))
    m, n, one = S.shape[1], len(p["mesh/nodes_B"]), np.eye(3)
    return {
        "modeBasis": p["modes/shapes_B"][:, :, :3].reshape(m, 3 * n).T.copy(),
        "trigList": [],
        "postProcessingModes": {},
        "massMatrixReduced": p["modes/mass"],
        "stiffnessMatrixReduced": p["modes/stiffness"],
        "infoList": [m, n, 3, 4, 7, 7 + m],
        "rigidBodyNodeType": "NodeType.RotationEulerParameters",
        "xRef": p["mesh/nodes_B"].ravel(),
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
    """Add the body; options are those of AddObjectFFRFreducedOrder of Exudyn."""
    import exudyn
    from exudyn.FEM import ObjectFFRFreducedOrderInterface

    p = read(file)
    body = ObjectFFRFreducedOrderInterface()
    body.SetWithDictionary(exudyn_data(p))
    m = len(p["modes/mass"])
    body.massMatrixFFRFreduced = np.zeros((7 + m, 7 + m))
    found = body.AddObjectFFRFreducedOrder(mbs, **options)
    damping = exudyn.MatrixContainer()
    damping.SetWithDenseMatrix(p["modes/damping"], useDenseMatrix=True)
    mbs.SetObjectParameter(found["oFFRFreducedOrder"], "dampingMatrixReduced", damping)
    return {**found, "package": p}


def weights(p: dict[str, Any]) -> Any:
    """Share of each node in the weight: exact in mass, mass centre and every mode, (n,).

    The nodal masses, changed as little as possible until they have the sums of the invariants.
    """
    w = p["nodal/mass"] / p["invariants/mass"]
    x, phi = p["mesh/nodes_B"], p["modes/shapes_B"][:, :, :3]
    rows = np.vstack([np.ones(len(w)), x.T, np.moveaxis(phi, 2, 1).reshape(-1, len(w))])
    sums = np.concatenate([[1.0], p["invariants/S0_B"] / p["invariants/mass"]])
    sums = np.concatenate([sums, (p["invariants/S_B"].T / p["invariants/mass"]).ravel()])
    size = np.abs(rows).max(axis=1)
    size[size == 0.0] = 1.0
    rows, sums = rows / size[:, None], sums / size
    scale = np.sqrt(w)
    return w + scale * np.linalg.lstsq(rows * scale, sums - rows @ w, rcond=1e-13)[0]


def add_weight(mbs: Any, body: dict[str, Any], gravity: Any) -> Any:
    """Weight as a load on all nodes."""
    from exudyn.itemInterface import Force, MarkerSuperElementPosition

    p = body["package"]
    share = weights(p)
    marker = mbs.AddMarker(
        MarkerSuperElementPosition(
            bodyNumber=body["oFFRFreducedOrder"],
            meshNodeNumbers=list(range(len(share))),
            weightingFactors=share,
        )
    )
    force = float(p["invariants/mass"]) * np.asarray(gravity, dtype=float)
    return mbs.AddLoad(Force(markerNumber=marker, loadVector=force))


def add_marker(mbs: Any, body: dict[str, Any], interface: str) -> Any:
    """Marker at the first node of an interface."""
    from exudyn.itemInterface import MarkerSuperElementPosition

    p = body["package"]
    label = p[f"interfaces/{interface}/node_ids"][0]
    node = int(np.flatnonzero(p["mesh/node_ids"] == label)[0])
    return mbs.AddMarker(
        MarkerSuperElementPosition(
            bodyNumber=body["oFFRFreducedOrder"], meshNodeNumbers=[node], weightingFactors=[1.0]
        )
    )
