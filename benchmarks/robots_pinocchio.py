"""Mass matrix, bias and gravity forces of URDF files by Pinocchio; Python with `pin` only.

    python benchmarks/robots_pinocchio.py OUT.npz FILE.urdf --root fixed|free --states 100

OUT gets names, coordinates and rates of the joints with one coordinate in the order of Pinocchio,
and for each state M (n, n), c (n,) and g (n,). A free root has the position and the matrix of its
frame; its rates are those of Pinocchio: velocity and angular velocity in axes of the body.
"""

import argparse

import numpy as np
import pinocchio as pin


def main() -> None:
    """Write the equations of one file."""
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("file")
    parser.add_argument("--root", choices=["fixed", "free"], default="fixed")
    parser.add_argument("--states", type=int, default=100)
    options = parser.parse_args()
    if options.root == "free":
        model = pin.buildModelFromUrdf(options.file, pin.JointModelFreeFlyer())
    else:
        model = pin.buildModelFromUrdf(options.file)
    data, random = model.createData(), np.random.default_rng(1)
    first = 2 if options.root == "free" else 1
    kept = {key: [] for key in ("values", "rates", "M", "c", "g", "r", "A")}
    for _ in range(options.states):
        q, v = pin.neutral(model), random.uniform(-2.0, 2.0, model.nv)
        values = random.uniform(-2.5, 2.5, model.njoints - first)
        for value, joint in zip(values, model.joints[first:], strict=True):
            if joint.nq == 1:
                q[joint.idx_q] = value
            else:  # continuous: cosine and sine
                q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        frame = pin.SE3.Random() if first == 2 else pin.SE3.Identity()
        if first == 2:
            q[:7] = pin.SE3ToXYZQUAT(frame)
            q[3:7] /= np.linalg.norm(q[3:7])
            frame = pin.XYZQUATToSE3(q[:7])
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        found = values, v, M, pin.nonLinearEffects(model, data, q, v).copy()
        gravity = pin.computeGeneralizedGravity(model, data, q).copy()
        whole = *found, gravity, frame.translation, frame.rotation
        for key, value in zip(kept, whole, strict=True):
            kept[key].append(np.array(value))
    names = list(model.names)[first:]
    np.savez(options.out, names=names, **{key: np.array(value) for key, value in kept.items()})


if __name__ == "__main__":
    main()
