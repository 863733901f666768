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
  // half of the walls along x2 and x3: elements that grow from the corner on,
  // their growth and length together [m], and equal elements of the rest
  elements_2 = {8, Min 1, Step 1, Name "Parameters/elements_2"},
  growth_2 = {1.7, Min 0, Name "Parameters/growth_2"},
  graded_2 = {0.0045, Min 0, Name "Parameters/graded_2"},
  even_2 = {3, Min 1, Step 1, Name "Parameters/even_2"},
  elements_3 = {7, Min 1, Step 1, Name "Parameters/elements_3"},
  growth_3 = {1.7, Min 0, Name "Parameters/growth_3"},
  graded_3 = {0.0026, Min 0, Name "Parameters/graded_3"},
  even_3 = {3, Min 1, Step 1, Name "Parameters/even_3"},
  // ends of the rows of elements, fractions of the thickness from the outer face
  rows() = {{0.16666667, 0.33333333, 0.5, 0.66666667, 0.83333333, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Columns clockwise from the top left corner. Of each wall: corner, end of the graded elements,
// middle of the hollow, begin of the graded elements.
a = width / 2;
b = height / 2;
left = -a + wall_left;
right = a - wall_right;
top = b - wall_top;
bottom = -b + wall_bottom;
m_2 = (left + right) / 2;
m_3 = (top + bottom) / 2;
rightwards[] = {left + graded_2, m_2, right - graded_2};
leftwards[] = {right - graded_2, m_2, left + graded_2};
downwards[] = {top - graded_3, m_3, bottom + graded_3};
upwards[] = {bottom + graded_3, m_3, top - graded_3};
outer_2[] = {-a, rightwards[], a, a, a, a, a, leftwards[], -a, -a, -a, -a};
outer_3[] = {b, b, b, b, b, downwards[], -b, -b, -b, -b, -b, upwards[]};
inner_2[] = {left, rightwards[], right, right, right, right,
             right, leftwards[], left, left, left, left};
inner_3[] = {top, top, top, top, top, downwards[], bottom, bottom, bottom, bottom,
             bottom, upwards[]};
closed = 1;
half_2[] = {elements_2, even_2, even_2, elements_2};
half_3[] = {elements_3, even_3, even_3, elements_3};
elements[] = {half_2[], half_3[], half_2[], half_3[]};
growth[] = {growth_2, 1, 1, 1 / growth_2, growth_3, 1, 1, 1 / growth_3,
            growth_2, 1, 1, 1 / growth_2, growth_3, 1, 1, 1 / growth_3};
Include "walls.geo";

n = 4 * #rows[];  // surfaces of each wall
Physical Surface("top") = {chain_surfaces[{0:n - 1}]};
Physical Surface("right") = {chain_surfaces[{n:2 * n - 1}]};
Physical Surface("bottom") = {chain_surfaces[{2 * n:3 * n - 1}]};
Physical Surface("left") = {chain_surfaces[{3 * n:4 * n - 1}]};
