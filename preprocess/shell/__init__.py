"""Laminated shells of flat triangles.

Axes and letters of the elements. `_G` are the axes of the model, `_E` those of one triangle and
of its laminate: e3 its normal, e1 the reference direction projected on it, e2 = e3 x e1. A corner
has six degrees of freedom, displacement ux uy uz [m] and rotation rx ry rz [rad], and a triangle
18, corner after corner. In E they are the membrane's (u, v, tz) and the plate's
(w, bx, by) of each corner, bx = ry and by = -rx, so that u(z) = u + z bx and v(z) = v + z by.

Strains come in the order e = (exx, eyy, gxy), k = (kxx, kyy, kxy) = (bx,x; by,y; bx,y + by,x),
gamma = (gxz, gyz) = grad w + (bx, by); resultants N = A e + B k [N/m], M = B e + D k [N],
T = Ds gamma [N/m].
"""
