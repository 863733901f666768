// Walls along a polyline, open or closed, with mitred corners: nine-node quadrilaterals in rows
// through the walls, closer together towards corners and ends. Opens in the gmsh window as it is.

DefineConstant[
  // ends of the columns on the outer and on the inner face: of each wall its begin, the end of the
  // graded elements, the middle, the begin of the graded elements; of an open line also its end [m]
  outer_2() = {{-0.001, -0.001, -0.001, -0.001, -0.001, 0.02, 0.05, 0.08, 0.1}, Name "Parameters/outer_2"},
  outer_3() = {{0.1, 0.08, 0.05, 0.02, -0.001, -0.001, -0.001, -0.001, -0.001}, Name "Parameters/outer_3"},
  inner_2() = {{0.001, 0.001, 0.001, 0.001, 0.001, 0.02, 0.05, 0.08, 0.1}, Name "Parameters/inner_2"},
  inner_3() = {{0.1, 0.08, 0.05, 0.02, 0.001, 0.001, 0.001, 0.001, 0.001}, Name "Parameters/inner_3"},
  closed = {0, Min 0, Max 1, Step 1, Name "Parameters/closed"},
  // between the columns: elements, and the length of each over that of the one before it
  elements() = {{8, 3, 3, 8, 8, 3, 3, 8}, Name "Parameters/elements"},
  growth() = {{1.3, 1, 1, 0.77, 1.3, 1, 1, 0.77}, Name "Parameters/growth"},
  numbers() = {{1, 2}, Name "Parameters/numbers"}, // of the walls, in their names
  // ends of the rows of elements, fractions of the thickness from the outer face
  rows() = {{0.2, 0.4, 0.6, 0.8, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

Include "walls.geo";

n = 4 * #rows[];  // surfaces of each wall
For w In {0:#numbers[] - 1}
  Physical Surface(Sprintf("wall-%g", numbers[w])) = {chain_surfaces[{w * n:(w + 1) * n - 1}]};
EndFor
