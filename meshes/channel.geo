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
  // half of each wall: elements that grow from corner or end on,
  // their growth and length together [m], and equal elements of the rest
  elements_top = {8, Min 1, Step 1, Name "Parameters/elements_top"},
  growth_top = {1.7, Min 0, Name "Parameters/growth_top"},
  graded_top = {0.0028, Min 0, Name "Parameters/graded_top"},
  even_top = {3, Min 1, Step 1, Name "Parameters/even_top"},
  elements_bottom = {9, Min 1, Step 1, Name "Parameters/elements_bottom"},
  growth_bottom = {1.7, Min 0, Name "Parameters/growth_bottom"},
  graded_bottom = {0.0055, Min 0, Name "Parameters/graded_bottom"},
  even_bottom = {3, Min 1, Step 1, Name "Parameters/even_bottom"},
  elements_web = {9, Min 1, Step 1, Name "Parameters/elements_web"},
  growth_web = {1.7, Min 0, Name "Parameters/growth_web"},
  graded_web = {0.0055, Min 0, Name "Parameters/graded_web"},
  even_web = {3, Min 1, Step 1, Name "Parameters/even_web"},
  // ends of the rows of elements, fractions of the thickness from the outer face
  rows() = {{0.5, 0.75, 0.9, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Columns from the end of the bottom flange along the web to the end of the top flange. Of each
// wall: corner or end, end of the graded elements, middle, begin of the graded elements.
b = height / 2;
top = b - wall_top;
bottom = -b + wall_bottom;
m_top = (top_width + wall_web) / 2;
m_bottom = (bottom_width + wall_web) / 2;
inwards[] = {bottom_width - graded_bottom, m_bottom, wall_web + graded_bottom};
outwards[] = {wall_web + graded_top, m_top, top_width - graded_top};
upwards[] = {bottom + graded_web, (top + bottom) / 2, top - graded_web};
outer_2[] = {bottom_width, inwards[], 0, 0, 0, 0, 0, outwards[], top_width};
inner_2[] = {bottom_width, inwards[], wall_web, wall_web, wall_web, wall_web,
             wall_web, outwards[], top_width};
outer_3[] = {-b, -b, -b, -b, -b, upwards[], b, b, b, b, b};
inner_3[] = {bottom, bottom, bottom, bottom, bottom, upwards[], top, top, top, top, top};
closed = 0;
elements[] = {elements_bottom, even_bottom, even_bottom, elements_bottom,
              elements_web, even_web, even_web, elements_web,
              elements_top, even_top, even_top, elements_top};
growth[] = {growth_bottom, 1, 1, 1 / growth_bottom, growth_web, 1, 1, 1 / growth_web,
            growth_top, 1, 1, 1 / growth_top};
Include "walls.geo";

n = 4 * #rows[];  // surfaces of each wall
Physical Surface("bottom") = {chain_surfaces[{0:n - 1}]};
Physical Surface("web") = {chain_surfaces[{n:2 * n - 1}]};
Physical Surface("top") = {chain_surfaces[{2 * n:3 * n - 1}]};
