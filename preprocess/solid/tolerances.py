"""Limits of meshes of solids."""

# Of the volume of a CAD file: difference up to which cells of the default size stay. Cells that are
# small enough for curved faces, 14 around a circle, keep it.
GAP = 1e-4

# Unknowns: up to so many, default cells become smaller for thin curved parts, and displacements of
# degree 3, with RICHER times as many unknowns, estimate the errors of frequencies.
MOST = 60_000
RICHER = 3.4  # 27/8 of fine meshes of hexahedra, measured 3.2 to 3.4 of tetrahedra

# Estimated error of a frequency or of a static deflection, as of shells and sections.
COARSE = 0.05
