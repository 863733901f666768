"""Cells of MED files: names, and the order of their nodes."""

# VTK type -> name in MED, and the nodes of VTK in the order of MED. The solids of MED are mirrored:
# their first face, seen from inside, turns the other way.
MED_CELLS: dict[int, tuple[str, list[int]]] = {
    1: ("PO1", [0]),
    3: ("SE2", [0, 1]),
    21: ("SE3", [0, 1, 2]),
    5: ("TR3", [0, 1, 2]),
    22: ("TR6", [0, 1, 2, 3, 4, 5]),
    9: ("QU4", [0, 1, 2, 3]),
    23: ("QU8", [0, 1, 2, 3, 4, 5, 6, 7]),
    10: ("TE4", [0, 2, 1, 3]),
    24: ("T10", [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]),
    12: ("HE8", [0, 3, 2, 1, 4, 7, 6, 5]),
    25: ("H20", [0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17]),
    13: ("PE6", [0, 2, 1, 3, 5, 4]),
    26: ("P15", [0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13]),
}
NO_PROFILE = "MED_NO_PROFILE_INTERNAL"
MESH_STEP = "-0000000000000000001-0000000000000000001"
FIELD = "DEPL"
COMPONENTS = ("DX", "DY", "DZ", "DRX", "DRY", "DRZ")
