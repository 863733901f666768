// I section: x = x2, y = x3, the web on the x3 axis, origin half way up. Sharp corners.
// Nine-node quadrilaterals in rows through the walls, closer together towards corners and ends.
// Opens in the gmsh window as it is.

DefineConstant[
  height = {0.2, Min 0, Name "Parameters/height"},                // outer, along x3 [m]
  top_width = {0.1, Min 0, Name "Parameters/top_width"},          // of the flanges, along x2 [m]
  bottom_width = {0.1, Min 0, Name "Parameters/bottom_width"},
  wall_top = {0.01, Min 0, Name "Parameters/wall_top"},           // thickness of each wall [m]
  wall_web = {0.006, Min 0, Name "Parameters/wall_web"},
  wall_bottom = {0.01, Min 0, Name "Parameters/wall_bottom"},
  // along a quarter of the flanges, half of the web
  elements_top = {6, Min 1, Step 1, Name "Parameters/elements_top"},
  elements_bottom = {6, Min 1, Step 1, Name "Parameters/elements_bottom"},
  elements_web = {7, Min 1, Step 1, Name "Parameters/elements_web"},
  // of the elements from the corners and the ends on
  growth_top = {1.7, Min 0, Name "Parameters/growth_top"},
  growth_bottom = {1.7, Min 0, Name "Parameters/growth_bottom"},
  growth_web = {1.7, Min 0, Name "Parameters/growth_web"},
  // ends of the rows of elements, fractions of the thickness: flanges from the outer face,
  // web from its right face
  rows_top() = {{0.5, 0.85, 1}, Name "Parameters/rows_top"},
  rows_bottom() = {{0.5, 0.85, 1}, Name "Parameters/rows_bottom"},
  rows_web() = {{0.15, 0.5, 0.85, 1}, Name "Parameters/rows_web"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Over the web each flange has a column at every row of the web.
n_web = #rows_web[];
web_faces[] = {0, rows_web[]};
across_2[] = {};  // from right to left
single[] = {};
equal[] = {};
For i In {0:n_web}
  across_2[] += wall_web / 2 - web_faces[i] * wall_web;
EndFor
For i In {1:n_web}
  single[] += 1;
  equal[] += 1;
EndFor
closed = 0;

// Bottom flange, from right to left.
a = bottom_width / 2;
b = height / 2;
m = a / 2 + wall_web / 4;  // middle of each side
outer_2[] = {a, m, across_2[], -m, -a};
outer_3[] = {};
inner_3[] = {};
For i In {0:n_web + 4}
  outer_3[] += -b;
  inner_3[] += -b + wall_bottom;
EndFor
inner_2[] = outer_2[];
rows[] = rows_bottom[];
elements[] = {elements_bottom, elements_bottom, single[], elements_bottom, elements_bottom};
growth[] = {growth_bottom, 1 / growth_bottom, equal[], growth_bottom, 1 / growth_bottom};
Include "walls.geo";
Physical Surface("bottom") = {chain_surfaces[]};

// Top flange, from left to right.
a = top_width / 2;
m = a / 2 + wall_web / 4;
outer_2[] = {-a, -m};
For i In {0:n_web}
  outer_2[] += across_2[n_web - i];
EndFor
outer_2[] += m;
outer_2[] += a;
outer_3[] = {};
inner_3[] = {};
For i In {0:n_web + 4}
  outer_3[] += b;
  inner_3[] += b - wall_top;
EndFor
inner_2[] = outer_2[];
rows[] = rows_top[];
elements[] = {elements_top, elements_top, single[], elements_top, elements_top};
growth[] = {growth_top, 1 / growth_top, equal[], growth_top, 1 / growth_top};
Include "walls.geo";
Physical Surface("top") = {chain_surfaces[]};

// Web, downwards: its right face is its outer one.
outer_2[] = {wall_web / 2, wall_web / 2, wall_web / 2};
inner_2[] = {-wall_web / 2, -wall_web / 2, -wall_web / 2};
outer_3[] = {b - wall_top, 0.5 * (wall_bottom - wall_top), -b + wall_bottom};
inner_3[] = outer_3[];
rows[] = rows_web[];
elements[] = {elements_web, elements_web};
growth[] = {growth_web, 1 / growth_web};
Include "walls.geo";
Physical Surface("web") = {chain_surfaces[]};

Coherence;  // the web's ends and the flanges' inner faces become one
