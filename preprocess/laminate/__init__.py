"""Laminates of plies: stiffness, transverse shear, mass, ply stresses and a report.

Laminate axes `_E`: e3 the normal of the shell, plies listed BOTTOM to TOP along it, ply angles
from e1 towards e2, right-handed about e3. The reference surface is the mesh: z = 0.
Strains are (exx, eyy, gxy), curvatures (kxx, kyy, kxy), shear (gxz, gyz), with
u = u0 + z beta; resultants N [N/m], M [N], T [N/m] in the same order.
"""
