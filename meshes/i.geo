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
  // a quarter of the flanges, half of the web: elements that grow from corner or
  // end on, their growth and length together [m], and equal elements of the rest
  elements_top = {8, Min 1, Step 1, Name "Parameters/elements_top"},
  growth_top = {1.7, Min 0, Name "Parameters/growth_top"},
  graded_top = {0.01, Min 0, Name "Parameters/graded_top"},
  even_top = {3, Min 1, Step 1, Name "Parameters/even_top"},
  elements_bottom = {8, Min 1, Step 1, Name "Parameters/elements_bottom"},
  growth_bottom = {1.7, Min 0, Name "Parameters/growth_bottom"},
  graded_bottom = {0.01, Min 0, Name "Parameters/graded_bottom"},
  even_bottom = {3, Min 1, Step 1, Name "Parameters/even_bottom"},
  elements_web = {9, Min 1, Step 1, Name "Parameters/elements_web"},
  growth_web = {1.7, Min 0, Name "Parameters/growth_web"},
  graded_web = {0.03, Min 0, Name "Parameters/graded_web"},
  even_web = {3, Min 1, Step 1, Name "Parameters/even_web"},
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

// Bottom flange, from right to left. Of each side: end, end of the graded elements, middle, begin
// of the graded elements, web.
a = bottom_width / 2;
b = height / 2;
w = wall_web / 2;
m = (a + w) / 2;
outer_2[] = {a, a - graded_bottom, m, w + graded_bottom, across_2[],
             -w - graded_bottom, -m, -a + graded_bottom, -a};
inner_2[] = outer_2[];
outer_3[] = {};
inner_3[] = {};
For i In {0:n_web + 8}
  outer_3[] += -b;
  inner_3[] += -b + wall_bottom;
EndFor
rows[] = rows_bottom[];
side_elements[] = {elements_bottom, even_bottom, even_bottom, elements_bottom};
side_growth[] = {growth_bottom, 1, 1, 1 / growth_bottom};
elements[] = {side_elements[], single[], side_elements[]};
growth[] = {side_growth[], equal[], side_growth[]};
Include "walls.geo";
Physical Surface("bottom") = {chain_surfaces[]};

// Top flange, from left to right.
a = top_width / 2;
m = (a + w) / 2;
outer_2[] = {-a, -a + graded_top, -m, -w - graded_top};
For i In {0:n_web}
  outer_2[] += across_2[n_web - i];
EndFor
outer_2[] += {w + graded_top, m, a - graded_top, a};
inner_2[] = outer_2[];
outer_3[] = {};
inner_3[] = {};
For i In {0:n_web + 8}
  outer_3[] += b;
  inner_3[] += b - wall_top;
EndFor
rows[] = rows_top[];
side_elements[] = {elements_top, even_top, even_top, elements_top};
side_growth[] = {growth_top, 1, 1, 1 / growth_top};
elements[] = {side_elements[], single[], side_elements[]};
growth[] = {side_growth[], equal[], side_growth[]};
Include "walls.geo";
Physical Surface("top") = {chain_surfaces[]};

// Web, downwards: its right face is its outer one.
top = b - wall_top;
bottom = -b + wall_bottom;
outer_2[] = {w, w, w, w, w};
inner_2[] = {-w, -w, -w, -w, -w};
outer_3[] = {top, top - graded_web, (top + bottom) / 2, bottom + graded_web, bottom};
inner_3[] = outer_3[];
rows[] = rows_web[];
elements[] = {elements_web, even_web, even_web, elements_web};
growth[] = {growth_web, 1, 1, 1 / growth_web};
Include "walls.geo";
Physical Surface("web") = {chain_surfaces[]};

Coherence;  // the web's ends and the flanges' inner faces become one
