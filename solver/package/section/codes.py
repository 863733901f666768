"""Other codes in whose order a section is shown, and their axes in ours."""

# Rows: axes of the code in ours (x1 along the beam, x2 and x3 in the section). Components of a
# vector follow as v_code = A @ v.
AXES = {
    "plymotion": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "vabs": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "becas": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "anba4": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
}
CODES = (*AXES, "beamdyn")

OF_MESHES = ("vabs", "becas")  # codes whose input is written for each section
OF_BLADES = ("beamdyn", "hawc2")  # codes that get one file for the stations of a blade
TARGETS = (*OF_MESHES, *OF_BLADES)
