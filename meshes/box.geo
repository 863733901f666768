// Rectangular box: x = x2 (width), y = x3 (height), centred at the origin. Four walls that meet
// in mitred corners, nine-node quadrilaterals in rows through the wall, closer together towards
// the corners. Opens in the gmsh window as it is.

DefineConstant[
  width = {0.0242, Min 0, Name "Parameters/width"},          // outer, along x2 [m]
  height = {0.0136, Min 0, Name "Parameters/height"},        // outer, along x3 [m]
  wall_top = {0.000762, Min 0, Name "Parameters/wall_top"},  // thickness of each wall [m]
  wall_right = {0.000762, Min 0, Name "Parameters/wall_right"},
  wall_bottom = {0.000762, Min 0, Name "Parameters/wall_bottom"},
  wall_left = {0.000762, Min 0, Name "Parameters/wall_left"},
  elements_2 = {10, Min 1, Step 1, Name "Parameters/elements_2"},  // along half of the width
  elements_3 = {9, Min 1, Step 1, Name "Parameters/elements_3"},   // along half of the height
  growth_2 = {1.7, Min 0, Name "Parameters/growth_2"},  // of the elements from the corner on
  growth_3 = {1.7, Min 0, Name "Parameters/growth_3"},
  // ends of the rows of elements, fractions of the thickness from the outer face
  rows() = {{0.16666667, 0.33333333, 0.5, 0.66666667, 0.83333333, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Columns clockwise from the top left corner: corner, middle of the top wall, corner, ...
a = width / 2;
b = height / 2;
outer_2[] = {-a, 0, a, a, a, 0, -a, -a};
outer_3[] = {b, b, b, 0, -b, -b, -b, 0};
inner_2[] = {-a + wall_left, 0, a - wall_right, a - wall_right,
             a - wall_right, 0, -a + wall_left, -a + wall_left};
inner_3[] = {b - wall_top, b - wall_top, b - wall_top, 0,
             -b + wall_bottom, -b + wall_bottom, -b + wall_bottom, 0};
closed = 1;
elements[] = {elements_2, elements_2, elements_3, elements_3,
              elements_2, elements_2, elements_3, elements_3};
growth[] = {growth_2, 1 / growth_2, growth_3, 1 / growth_3,
            growth_2, 1 / growth_2, growth_3, 1 / growth_3};
Include "walls.geo";

n = 2 * #rows[];  // surfaces of each wall
Physical Surface("top") = {chain_surfaces[{0:n - 1}]};
Physical Surface("right") = {chain_surfaces[{n:2 * n - 1}]};
Physical Surface("bottom") = {chain_surfaces[{2 * n:3 * n - 1}]};
Physical Surface("left") = {chain_surfaces[{3 * n:4 * n - 1}]};
