// A rectangle of triangles: surface "panel", edges "root" and "tip".
DefineConstant[
  length = {1.2, Name "Parameters/length"}
  width = {0.4, Name "Parameters/width"}
  n_length = {24, Name "Parameters/n_length"}
  n_width = {8, Name "Parameters/n_width"}
];
Point(1) = {0, 0, 0};
Point(2) = {length, 0, 0};
Point(3) = {length, width, 0};
Point(4) = {0, width, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = n_length + 1;
Transfinite Curve {2, 4} = n_width + 1;
Transfinite Surface {1} Alternate;
Physical Surface("panel") = {1};
Physical Curve("root") = {4};
Physical Curve("tip") = {2};
