// Rectangular cross-section: x = x2 (width), y = x3 (height), centred at the origin. Nine-node
// quadrilaterals in rows and columns. Opens in the gmsh window as it is.

DefineConstant[
  width = {0.06, Min 0, Name "Parameters/width"},    // along x2 [m]
  height = {0.015, Min 0, Name "Parameters/height"}, // along x3 [m]
  // ends of the columns, fractions of the width from the left edge
  columns() = {{0.02, 0.07, 0.15, 0.26, 0.38, 0.5, 0.62, 0.74, 0.85, 0.93, 0.98, 1},
    Name "Parameters/columns"},
  // ends of the rows, fractions of the height from the top
  rows() = {{0.06, 0.2, 0.4, 0.6, 0.8, 0.94, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

one_column[] = {};
For i In {1:#columns[]}
  one_column[] += 1;
EndFor
one_row[] = {};
For i In {1:#rows[]}
  one_row[] += 1;
EndFor

// Extruded layers end at the given fractions exactly.
Point(1) = {-width / 2, height / 2, 0};
side[] = Extrude {0, -height, 0} { Point{1}; Layers{ one_row[], rows[] }; };
face[] = Extrude {width, 0, 0} {
  Line{side[1]}; Layers{ one_column[], columns[] }; Recombine;
};

Physical Surface("section") = {face[1]};
