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
  // along half of the top and bottom left and right of the web, half of the sides and of the web
  elements_left = {8, Min 1, Step 1, Name "Parameters/elements_left"},
  elements_right = {8, Min 1, Step 1, Name "Parameters/elements_right"},
  elements_3 = {8, Min 1, Step 1, Name "Parameters/elements_3"},
  growth_left = {1.7, Min 0, Name "Parameters/growth_left"},  // of the elements from corners on
  growth_right = {1.7, Min 0, Name "Parameters/growth_right"},
  growth_3 = {1.7, Min 0, Name "Parameters/growth_3"},
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

// Skin, clockwise from the top left corner.
left = -a + wall_left;
right = a - wall_right;
half_left = 0.5 * (left + web_position - wall_web / 2);  // middle of each cell's width
half_right = 0.5 * (right + web_position + wall_web / 2);
outer_2[] = {-a, half_left, rightwards_2[], half_right, a, a,
             a, half_right, leftwards_2[], half_left, -a, -a};
inner_2[] = {left, half_left, rightwards_2[], half_right, right, right,
             right, half_right, leftwards_2[], half_left, left, left};
outer_3[] = {b, b, top_outer[], b, b, 0, -b, -b, bottom_outer[], -b, -b, 0};
t = b - wall_top;
s = -b + wall_bottom;
inner_3[] = {t, t, top_inner[], t, t, 0, s, s, bottom_inner[], s, s, 0};
closed = 1;
rows[] = rows_skin[];
elements[] = {elements_left, elements_left, single[], elements_right, elements_right,
              elements_3, elements_3,
              elements_right, elements_right, single[], elements_left, elements_left,
              elements_3, elements_3};
growth[] = {growth_left, 1 / growth_left, equal[], growth_right, 1 / growth_right,
            growth_3, 1 / growth_3,
            growth_right, 1 / growth_right, equal[], growth_left, 1 / growth_left,
            growth_3, 1 / growth_3};
Include "walls.geo";
n = #rows[] * (4 + n_web);  // surfaces of top and bottom
m = #rows[] * 2;            // of right and left
Physical Surface("top") = {chain_surfaces[{0:n - 1}]};
Physical Surface("right") = {chain_surfaces[{n:n + m - 1}]};
Physical Surface("bottom") = {chain_surfaces[{n + m:2 * n + m - 1}]};
Physical Surface("left") = {chain_surfaces[{2 * n + m:2 * (n + m) - 1}]};

// Web, downwards: its right face is its outer one.
x = web_position + wall_web / 2;
outer_2[] = {x, x, x};
inner_2[] = {x - wall_web, x - wall_web, x - wall_web};
outer_3[] = {t, 0.5 * (s + t), s};
inner_3[] = outer_3[];
closed = 0;
rows[] = rows_web[];
elements[] = {elements_3, elements_3};
growth[] = {growth_3, 1 / growth_3};
Include "walls.geo";
Physical Surface("web") = {chain_surfaces[]};

Coherence;  // the web's ends and the skin's inner face become one
