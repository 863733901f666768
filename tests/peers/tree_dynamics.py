"""Equations of a robot in joint coordinates by the recursive Newton-Euler method, from its URDF.

A second method, which shares no code with ours: it reads the XML itself and works in global axes.
R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 5.
"""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np


def turn(axis, angle):
    """Return Rodrigues' rotation (3, 3) about a unit vector."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def _origin(element):
    found = None if element is None else element.find("origin")
    given = {} if found is None else found.attrib
    p = np.array([float(x) for x in given.get("xyz", "0 0 0").split()])
    r, q, w = (float(x) for x in given.get("rpy", "0 0 0").split())
    return p, turn((0, 0, 1), w) @ turn((0, 1, 0), q) @ turn((1, 0, 0), r)


class Tree:
    """A robot with its root on the ground; `names` are those of its coordinates."""

    def __init__(self, file: Path) -> None:
        robot = ET.parse(file).getroot()
        self.links = {link.get("name"): link for link in robot.findall("link")}
        self.below, children, self.names = {}, set(), []
        for joint in robot.findall("joint"):
            name, kind = joint.get("name"), joint.get("type")
            axis = [1.0, 0.0, 0.0]
            if joint.find("axis") is not None:
                axis = [float(x) for x in joint.find("axis").get("xyz").split()]
            axis = np.array(axis) / np.linalg.norm(axis)
            if kind == "planar":  # about z
                kinds = [(0, np.eye(3)[0]), (0, np.eye(3)[1]), (1, axis)]
                self.names += [f"{name}.{c}" for c in ("x", "y", "angle")]
            else:
                kinds = [(int(kind != "prismatic"), axis)] if kind != "fixed" else []
                self.names += [f"{name}.{'angle' if kinds[0][0] else 'z'}"] if kinds else []
            first = len(self.names) - len(kinds)
            child = joint.find("child").get("link")
            children.add(child)
            parent = joint.find("parent").get("link")
            self.below.setdefault(parent, []).append((child, *_origin(joint), kinds, first))
        self.root = next(name for name in self.links if name not in children)

    def forces(self, q, qd, qdd, gravity):
        """Return the forces (n,) that give these accelerations."""
        tau, zero = np.zeros(len(self.names)), np.zeros(3)

        def visit(link, p, A, v_p, w, wd):  # v_p: acceleration of p, gravity as one of the ground
            c, R = _origin(self.links[link].find("inertial"))
            F, N = np.zeros(3), np.zeros(3)  # about p
            inertial = self.links[link].find("inertial")
            if inertial is not None:
                m = float(inertial.find("mass").get("value"))
                g = {k: float(x) for k, x in inertial.find("inertia").attrib.items()}
                J = [[g["ixx"], g["ixy"], g["ixz"]], [g["ixy"], g["iyy"], g["iyz"]]]
                J = A @ R @ np.array([*J, [g["ixz"], g["iyz"], g["izz"]]]) @ (A @ R).T
                c = A @ c
                F = m * (v_p + np.cross(wd, c) + np.cross(w, np.cross(w, c)))
                N = J @ wd + np.cross(w, J @ w) + np.cross(c, F)
            for child, offset, turned, kinds, first in self.below.get(link, []):
                d = A @ offset
                at, B = p + d, A @ turned
                a = v_p + np.cross(wd, d) + np.cross(w, np.cross(w, d))
                u, ud, path = w.copy(), wd.copy(), []
                for k, (rotates, axis) in enumerate(kinds, first):
                    n = B @ axis
                    path.append((k, rotates, n, at))
                    if rotates:
                        ud = ud + n * qdd[k] + np.cross(u, n * qd[k])
                        u, B = u + n * qd[k], B @ turn(axis, q[k])
                    else:
                        a = a + n * qdd[k] + 2 * np.cross(u, n * qd[k])
                        a = a + np.cross(ud, n * q[k]) + np.cross(u, np.cross(u, n * q[k]))
                        at = at + n * q[k]
                F_c, N_c = visit(child, at, B, a, u, ud)
                for k, rotates, n, place in path:
                    tau[k] = n @ (N_c + np.cross(at - place, F_c)) if rotates else n @ F_c
                F, N = F + F_c, N + N_c + np.cross(at - p, F_c)
            return F, N

        visit(self.root, zero, np.eye(3), -np.array(gravity), zero, zero)
        return tau

    def equations(self, q, qd, gravity):
        """Return M (n, n) and c (n,)."""
        n, zero = len(q), np.zeros(len(q))
        M = np.array([self.forces(q, zero, e, np.zeros(3)) for e in np.eye(n)]).T
        return M, self.forces(q, qd, zero, gravity)
