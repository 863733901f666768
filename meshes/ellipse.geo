// Elliptic cross-section: x = x2, y = x3, centred at the origin. Nine-node quadrilaterals as an
// O-grid: a rhombic core and four rings of columns around it. Opens in the gmsh window as it is.

DefineConstant[
  radius_2 = {0.01, Min 0, Name "Parameters/radius_2"},      // half-axis along x2 [m]
  radius_3 = {0.01, Min 0, Name "Parameters/radius_3"},      // half-axis along x3 [m]
  elements_arc = {10, Min 1, Step 1, Name "Parameters/elements_arc"},  // on a quarter of the edge
  elements_radial = {6, Min 1, Step 1, Name "Parameters/elements_radial"}  // from core to edge
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

core = 0.6;  // half-axes of the core relative to the section's

// Corner k on the half-axes at 0, 90, 180, 270 degrees (gmsh's ellipse arcs run from axis to
// axis): 10 + k on the core, 20 + k on the edge.
Point(1) = {0, 0, 0};
corner_2[] = {1, 0, -1, 0};
corner_3[] = {0, 1, 0, -1};
For k In {0:3}
  Point(10 + k) = {core * corner_2[k] * radius_2, core * corner_3[k] * radius_3, 0};
  Point(20 + k) = {corner_2[k] * radius_2, corner_3[k] * radius_3, 0};
EndFor
major = (radius_2 >= radius_3) ? 20 : 21;
For k In {0:3}
  next = (k + 1) % 4;
  Line(10 + k) = {10 + k, 10 + next};
  Ellipse(20 + k) = {20 + k, 1, major, 20 + next};
  Line(30 + k) = {10 + k, 20 + k};
EndFor
// Equal steps of the eccentric angle, nearly: the short ones where the edge bends most.
growth = (radius_2 / radius_3)^(1 / Max(elements_arc - 1, 1));
Transfinite Curve {10:13} = elements_arc + 1;
Transfinite Curve {20, 22} = elements_arc + 1 Using Progression growth;
Transfinite Curve {21, 23} = elements_arc + 1 Using Progression 1 / growth;
Transfinite Curve {30:33} = elements_radial + 1;

Curve Loop(1) = {10, 11, 12, 13};
Plane Surface(1) = {1};
Transfinite Surface {1} = {10, 11, 12, 13};
For k In {0:3}
  next = (k + 1) % 4;
  Curve Loop(2 + k) = {30 + k, 20 + k, -(30 + next), -(10 + k)};
  Plane Surface(2 + k) = {2 + k};
  Transfinite Surface {2 + k} = {10 + k, 20 + k, 20 + next, 10 + next};
EndFor
Recombine Surface {1:5};

Physical Surface("section") = {1:5};
