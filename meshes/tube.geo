// Circular tube or part of one: x = x2, y = x3, centre of the circles at the origin. Nine-node
// quadrilaterals in rows through the wall. Opens in the gmsh window as it is.

DefineConstant[
  outer_radius = {0.05, Min 0, Name "Parameters/outer_radius"},  // [m]
  wall = {0.005, Min 0, Name "Parameters/wall"},                 // thickness [m]
  start_deg = {0, Name "Parameters/start_deg"},        // where the wall begins, from x2 to x3
  span_deg = {360, Min 0, Max 360, Name "Parameters/span_deg"},  // 360: a closed tube
  // patches: their ends as fractions of the span, each of less than half a turn; elements along
  // each, and length of each element over that of the one before it
  patches() = {{0.25, 0.5, 0.75, 1}, Name "Parameters/patches"},
  elements() = {{9, 9, 9, 9}, Name "Parameters/elements"},
  growth() = {{1, 1, 1, 1}, Name "Parameters/growth"},
  // ends of the rows of elements, fractions of the thickness from the outer face
  rows() = {{0.25, 0.5, 0.75, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

n_patches = #patches[];
n_columns = (span_deg == 360) ? n_patches : n_patches + 1;
n_rows = #rows[];
faces[] = {0, rows[]};
stations[] = {0, patches[]};

Point(1) = {0, 0, 0};
first_point = newp;  // of column c on face j: first_point + c (n_rows + 1) + j
For c In {0:n_columns - 1}
  angle = (start_deg + span_deg * stations[c]) * Pi / 180;
  For j In {0:n_rows}
    r = outer_radius - faces[j] * wall;
    Point(first_point + c * (n_rows + 1) + j) = {r * Cos(angle), r * Sin(angle), 0};
  EndFor
EndFor

across = newl;  // of column c in row j: across + c n_rows + j
For c In {0:n_columns - 1}
  For j In {0:n_rows - 1}
    p = first_point + c * (n_rows + 1) + j;
    Line(across + c * n_rows + j) = {p, p + 1};
    Transfinite Curve {across + c * n_rows + j} = 2;
  EndFor
EndFor

along = newl;  // of patch c on face j: along + c (n_rows + 1) + j
For c In {0:n_patches - 1}
  next = (c + 1) % n_columns;
  For j In {0:n_rows}
    l = along + c * (n_rows + 1) + j;
    Circle(l) = {first_point + c * (n_rows + 1) + j, 1, first_point + next * (n_rows + 1) + j};
    Transfinite Curve {l} = elements[c] + 1 Using Progression growth[c];
  EndFor
EndFor

surfaces[] = {};
For c In {0:n_patches - 1}
  next = (c + 1) % n_columns;
  For j In {0:n_rows - 1}
    l = along + c * (n_rows + 1) + j;
    loop = newll;
    Curve Loop(loop) = {l, across + next * n_rows + j, -(l + 1), -(across + c * n_rows + j)};
    patch = news;
    Surface(patch) = {loop};
    Transfinite Surface {patch};
    Recombine Surface {patch};
    surfaces[] += patch;
  EndFor
EndFor
Physical Surface("wall") = {surfaces[]};
