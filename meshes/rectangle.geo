// Rectangular cross-section: x = x2 (width), y = x3 (height), centred at the origin.
// Nine-node quadrilaterals in rows and columns, closer together towards the edges, where the
// stresses of an anisotropic section are singular. Opens in the gmsh window as it is.

DefineConstant[
  width = {0.06, Min 0, Name "Parameters/width"},            // along x2 [m]
  height = {0.015, Min 0, Name "Parameters/height"},         // along x3 [m]
  elements_2 = {16, Min 1, Step 1, Name "Parameters/elements_2"},  // along the width
  elements_3 = {8, Min 1, Step 1, Name "Parameters/elements_3"},   // along the height
  grading = {0.5, Min 0, Max 1, Name "Parameters/grading"}   // 0: equal, 1: cosine spacing
];

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 0;

// Ends of the rows and columns as fractions: given as layers they are exact in every gmsh.
rows[] = {}; row_ends[] = {};
For i In {1:elements_3}
  s = i / elements_3;
  rows[] += 1; row_ends[] += (1 - grading) * s + grading * (1 - Cos(Pi * s)) / 2;
EndFor
columns[] = {}; column_ends[] = {};
For i In {1:elements_2}
  s = i / elements_2;
  columns[] += 1; column_ends[] += (1 - grading) * s + grading * (1 - Cos(Pi * s)) / 2;
EndFor

Point(1) = {-width / 2, -height / 2, 0};
side[] = Extrude {0, height, 0} { Point{1}; Layers{ rows[], row_ends[] }; };
face[] = Extrude {width, 0, 0} {
  Line{side[1]}; Layers{ columns[], column_ends[] }; Recombine;
};

Physical Surface("section") = {face[1]};
