// Rectangular box with a web between top and bottom: x = x2 (width), y = x3 (height), centred at
// the origin. Mitred corners. Nine-node quadrilaterals in rows through the walls, closer together
// towards the corners. Opens in the gmsh window as it is.

DefineConstant[
  width = {0.05, Min 0, Name "Parameters/width"},            // outer, along x2 [m]
  height = {0.02, Min 0, Name "Parameters/height"},          // outer, along x3 [m]
  web_position = {0, Name "Parameters/web_position"},        // x2 of the web's middle [m]
  wall_top = {0.001, Min 0, Name "Parameters/wall_top"},     // thickness of each wall [m]
  wall_right = {0.001, Min 0, Name "Parameters/wall_right"},
  wall_bottom = {0.001, Min 0, Name "Parameters/wall_bottom"},
  wall_left = {0.001, Min 0, Name "Parameters/wall_left"},
  wall_web = {0.001, Min 0, Name "Parameters/wall_web"},
  // half of top and bottom left and right of the web, of sides and web: elements that grow from
  // the corner on, their growth and length together [m], and equal elements of the rest
  elements_left = {8, Min 1, Step 1, Name "Parameters/elements_left"},
  growth_left = {1.7, Min 0, Name "Parameters/growth_left"},
  graded_left = {0.0045, Min 0, Name "Parameters/graded_left"},
  even_left = {3, Min 1, Step 1, Name "Parameters/even_left"},
  elements_right = {8, Min 1, Step 1, Name "Parameters/elements_right"},
  growth_right = {1.7, Min 0, Name "Parameters/growth_right"},
  graded_right = {0.0045, Min 0, Name "Parameters/graded_right"},
  even_right = {3, Min 1, Step 1, Name "Parameters/even_right"},
  elements_3 = {7, Min 1, Step 1, Name "Parameters/elements_3"},
  growth_3 = {1.7, Min 0, Name "Parameters/growth_3"},
  graded_3 = {0.0026, Min 0, Name "Parameters/graded_3"},
  even_3 = {3, Min 1, Step 1, Name "Parameters/even_3"},
  // ends of the rows of elements, fractions of the thickness: skin from the outer face, web from
  // its right face
  rows_skin() = {{0.25, 0.5, 0.75, 1}, Name "Parameters/rows_skin"},
  rows_web() = {{0.25, 0.5, 0.75, 1}, Name "Parameters/rows_web"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Over the web, top and bottom have a column at every row of the web.
n_web = #rows_web[];
web_faces[] = {0, rows_web[]};
leftwards_2[] = {};
rightwards_2[] = {};
single[] = {};
equal[] = {};
top_outer[] = {};
top_inner[] = {};
bottom_outer[] = {};
bottom_inner[] = {};
a = width / 2;
b = height / 2;
For i In {0:n_web}
  leftwards_2[] += web_position + wall_web * (0.5 - web_faces[i]);
  rightwards_2[] += web_position + wall_web * (0.5 - web_faces[n_web - i]);
  top_outer[] += b;
  top_inner[] += b - wall_top;
  bottom_outer[] += -b;
  bottom_inner[] += -b + wall_bottom;
EndFor
For i In {1:n_web}
  single[] += 1;
  equal[] += 1;
EndFor

// Skin, clockwise from the top left corner. Of each straight part: corner, end of the graded
// elements, middle, begin of the graded elements.
left = -a + wall_left;
right = a - wall_right;
top = b - wall_top;
bottom = -b + wall_bottom;
w_left = web_position - wall_web / 2;
w_right = web_position + wall_web / 2;
m_left = (left + w_left) / 2;
m_right = (right + w_right) / 2;
m_3 = (top + bottom) / 2;
rightwards[] = {left + graded_left, m_left, w_left - graded_left, rightwards_2[],
                w_right + graded_right, m_right, right - graded_right};
leftwards[] = {right - graded_right, m_right, w_right + graded_right, leftwards_2[],
               w_left - graded_left, m_left, left + graded_left};
downwards[] = {top - graded_3, m_3, bottom + graded_3};
upwards[] = {bottom + graded_3, m_3, top - graded_3};
outer_2[] = {-a, rightwards[], a, a, a, a, a, leftwards[], -a, -a, -a, -a};
inner_2[] = {left, rightwards[], right, right, right, right,
             right, leftwards[], left, left, left, left};
outer_3[] = {b, b, b, b, top_outer[], b, b, b, b, downwards[],
             -b, -b, -b, -b, bottom_outer[], -b, -b, -b, -b, upwards[]};
inner_3[] = {top, top, top, top, top_inner[], top, top, top, top, downwards[],
             bottom, bottom, bottom, bottom, bottom_inner[], bottom, bottom, bottom, bottom,
             upwards[]};
closed = 1;
rows[] = rows_skin[];
half_l[] = {elements_left, even_left, even_left, elements_left};
half_r[] = {elements_right, even_right, even_right, elements_right};
half_3[] = {elements_3, even_3, even_3, elements_3};
elements[] = {half_l[], single[], half_r[], half_3[], half_r[], single[], half_l[], half_3[]};
growth_l[] = {growth_left, 1, 1, 1 / growth_left};
growth_r[] = {growth_right, 1, 1, 1 / growth_right};
growth_s[] = {growth_3, 1, 1, 1 / growth_3};
growth[] = {growth_l[], equal[], growth_r[], growth_s[],
            growth_r[], equal[], growth_l[], growth_s[]};
Include "walls.geo";
n = #rows[] * (8 + n_web);  // surfaces of top and bottom
m = #rows[] * 4;            // of right and left
Physical Surface("top") = {chain_surfaces[{0:n - 1}]};
Physical Surface("right") = {chain_surfaces[{n:n + m - 1}]};
Physical Surface("bottom") = {chain_surfaces[{n + m:2 * n + m - 1}]};
Physical Surface("left") = {chain_surfaces[{2 * n + m:2 * (n + m) - 1}]};

// Web, downwards: its right face is its outer one.
outer_2[] = {w_right, w_right, w_right, w_right, w_right};
inner_2[] = {w_left, w_left, w_left, w_left, w_left};
outer_3[] = {top, downwards[], bottom};
inner_3[] = outer_3[];
closed = 0;
rows[] = rows_web[];
elements[] = half_3[];
growth[] = growth_s[];
Include "walls.geo";
Physical Surface("web") = {chain_surfaces[]};

Coherence;  // the web's ends and the skin's inner face become one
