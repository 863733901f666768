// Rectangle of two materials side by side: x = x2 (width), y = x3 (height), centred at the origin.
// Nine-node quadrilaterals in rows and columns. Opens in the gmsh window as it is.

DefineConstant[
  width = {0.1, Min 0, Name "Parameters/width"},      // along x2 [m]
  height = {0.1, Min 0, Name "Parameters/height"},    // along x3 [m]
  interface = {0, Name "Parameters/interface"},       // x2 where the materials meet [m]
  // ends of the columns, fractions of each part's width from its left edge
  columns_left() = {{0.2, 0.5, 0.8, 0.95, 1}, Name "Parameters/columns_left"},
  columns_right() = {{0.05, 0.2, 0.5, 0.8, 1}, Name "Parameters/columns_right"},
  // ends of the rows, fractions of the height from the top
  rows() = {{0.06, 0.2, 0.4, 0.6, 0.8, 0.94, 1}, Name "Parameters/rows"}
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

one_left[] = {};
For i In {1:#columns_left[]}
  one_left[] += 1;
EndFor
one_right[] = {};
For i In {1:#columns_right[]}
  one_right[] += 1;
EndFor
one_row[] = {};
For i In {1:#rows[]}
  one_row[] += 1;
EndFor

// Extruded layers end at the given fractions exactly. The second part starts from the first's edge.
Point(1) = {-width / 2, height / 2, 0};
side[] = Extrude {0, -height, 0} { Point{1}; Layers{ one_row[], rows[] }; };
left[] = Extrude {interface + width / 2, 0, 0} {
  Line{side[1]}; Layers{ one_left[], columns_left[] }; Recombine;
};
right[] = Extrude {width / 2 - interface, 0, 0} {
  Line{left[0]}; Layers{ one_right[], columns_right[] }; Recombine;
};

Physical Surface("left") = {left[1]};
Physical Surface("right") = {right[1]};
