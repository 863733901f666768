// Channel: a web and two flanges of any width that point along x2. Outer face of the web at
// x2 = 0, origin half way up the web. The walls meet in mitred corners. Nine-node quadrilaterals
// in rows through the walls, closer together towards corners and ends. Opens in the gmsh window
// as it is.

DefineConstant[
  height = {0.0254, Min 0, Name "Parameters/height"},             // outer, along x3 [m]
  top_width = {0.0127, Min 0, Name "Parameters/top_width"},       // of the flanges, from x2 = 0 [m]
  bottom_width = {0.0254, Min 0, Name "Parameters/bottom_width"},
  wall_top = {0.001524, Min 0, Name "Parameters/wall_top"},       // thickness of each wall [m]
  wall_web = {0.001524, Min 0, Name "Parameters/wall_web"},
  wall_bottom = {0.001524, Min 0, Name "Parameters/wall_bottom"},
  elements_top = {8, Min 1, Step 1, Name "Parameters/elements_top"},  // along half of each
  elements_bottom = {9, Min 1, Step 1, Name "Parameters/elements_bottom"},
  elements_web = {8, Min 1, Step 1, Name "Parameters/elements_web"},
  growth_top = {1.7, Min 0, Name "Parameters/growth_top"},  // of the elements from both ends on
  growth_bottom = {1.7, Min 0, Name "Parameters/growth_bottom"},
  growth_web = {1.7, Min 0, Name "Parameters/growth_web"},
  // ends of the rows of elements, fractions of the thickness from the outer face
  rows() = {{0.5, 0.75, 0.9, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Columns from the end of the bottom flange along the web to the end of the top flange.
b = height / 2;
outer_2[] = {bottom_width, bottom_width / 2, 0, 0, 0, top_width / 2, top_width};
outer_3[] = {-b, -b, -b, 0, b, b, b};
inner_2[] = {bottom_width, (bottom_width + wall_web) / 2, wall_web, wall_web,
             wall_web, (top_width + wall_web) / 2, top_width};
inner_3[] = {-b + wall_bottom, -b + wall_bottom, -b + wall_bottom, 0,
             b - wall_top, b - wall_top, b - wall_top};
closed = 0;
elements[] = {elements_bottom, elements_bottom, elements_web,
              elements_web, elements_top, elements_top};
growth[] = {growth_bottom, 1 / growth_bottom, growth_web,
            1 / growth_web, growth_top, 1 / growth_top};
Include "walls.geo";

n = 2 * #rows[];  // surfaces of each wall
Physical Surface("bottom") = {chain_surfaces[{0:n - 1}]};
Physical Surface("web") = {chain_surfaces[{n:2 * n - 1}]};
Physical Surface("top") = {chain_surfaces[{2 * n:3 * n - 1}]};
