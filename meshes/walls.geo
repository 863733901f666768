// Included by the scripts of thin-walled sections, once for each chain of walls (no Macro: gmsh
// reads a script with one only once in a process).
//
// A chain is a list of columns, lines from the outer face to the inner one. Between two columns
// lies a patch, cut into rows by straight lines at given fractions of the columns.
//
//   outer_2[], outer_3[], inner_2[], inner_3[]   ends of each column [m]
//   closed                                       1: a patch between the last column and the first
//   rows[]          ends of the rows as fractions of the columns from the outer face, last 1
//   elements[]      along each patch
//   growth[]        length of each element over that of the one before it, along each patch
//
// Gives chain_surfaces[], row by row within each patch. The chain runs clockwise around a cell
// (the outer face to its left), so that cells are counter-clockwise. Chains that meet share
// points and lines after `Coherence;`.

n_columns = #outer_2[];
n_patches = closed ? n_columns : n_columns - 1;
n_rows = #rows[];
faces[] = {0, rows[]};
chain_surfaces[] = {};

chain_point = newp;  // of column c on face j: chain_point + c (n_rows + 1) + j
For c In {0:n_columns - 1}
  For j In {0:n_rows}
    f = faces[j];
    Point(chain_point + c * (n_rows + 1) + j) = {
      (1 - f) * outer_2[c] + f * inner_2[c], (1 - f) * outer_3[c] + f * inner_3[c], 0};
  EndFor
EndFor

chain_across = newl;  // of column c in row j: chain_across + c n_rows + j
For c In {0:n_columns - 1}
  For j In {0:n_rows - 1}
    p = chain_point + c * (n_rows + 1) + j;
    Line(chain_across + c * n_rows + j) = {p, p + 1};
    Transfinite Curve {chain_across + c * n_rows + j} = 2;
  EndFor
EndFor

chain_along = newl;  // of patch c on face j: chain_along + c (n_rows + 1) + j
For c In {0:n_patches - 1}
  next = (c + 1) % n_columns;
  For j In {0:n_rows}
    l = chain_along + c * (n_rows + 1) + j;
    Line(l) = {chain_point + c * (n_rows + 1) + j, chain_point + next * (n_rows + 1) + j};
    Transfinite Curve {l} = elements[c] + 1 Using Progression growth[c];
  EndFor
EndFor

For c In {0:n_patches - 1}
  next = (c + 1) % n_columns;
  For j In {0:n_rows - 1}
    l = chain_along + c * (n_rows + 1) + j;
    loop = newll;
    Curve Loop(loop) = {chain_across + c * n_rows + j, l + 1,
                        -(chain_across + next * n_rows + j), -l};
    patch = news;
    Plane Surface(patch) = {loop};
    Transfinite Surface {patch};
    Recombine Surface {patch};
    chain_surfaces[] += patch;
  EndFor
EndFor
