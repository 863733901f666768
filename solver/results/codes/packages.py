"""Codes of warnings of files that are read or written: bodies, shells, sections and blades.

Those of a body are in the provenance of its package and are repeated with every run of the body;
those of a section or shell are in its file. The preprocessor does not import this list: a
contract test compares codes and limits with its source.
"""

from math import nan

from ..finding import Code


def _code(name: str, meaning: str, threshold: str, remedy: str, limit: float = nan) -> Code:
    return Code(name, "warning", meaning, threshold, remedy, limit)


BODY_CODES = (
    _code(
        "package-doubtful",
        "numbers of a package contradict each other; the run was asked to use them",
        "an error of `plymotion validate`, with `--allow-doubtful`",
        "correct the package",
    ),
    _code(
        "mesh-coarse-for-modes",
        "the mesh of a beam is coarse for some of its modes",
        "estimated relative error of a frequency above {limit:g}",
        "increase `elements`",
        0.01,
    ),
    _code(
        "static-modes-dependent",
        "a static mode that was asked for is left out: the reference condition carries its load, "
        "or its shape is a combination of other modes, or moves no mass",
        "energy norm of what is new in the shape below {limit:g} of the whole",
        "none needed; do not ask for the mode",
        1e-6,
    ),
    _code(
        "measured-shape-rigid",
        "a measured shape of a free body contains motion of the body as a whole; it was removed",
        "share of the mass norm above {limit:g}",
        "check nodal masses and suspension",
        0.1,
    ),
    _code(
        "measured-modal-mass",
        "the nodal masses give a mass-normalised measured shape another modal mass than 1",
        "difference above {limit:g}",
        "check nodal masses and the scale of the shapes",
        0.1,
    ),
    _code(
        "measured-shapes-coupled",
        "two measured shapes are not orthogonal in the nodal masses; the second was made "
        "orthogonal to the first",
        "cosine above {limit:g}",
        "check masses and shapes",
        0.1,
    ),
    _code(
        "interface-without-rotation",
        "the nodes of an interface show fewer than three rotations and none was measured",
        "rank of the nodes' places below 3",
        "give at least three nodes off one line, or the columns `rx`, `ry`, `rz`",
    ),
)

SHELL_CODES = (
    _code(
        "sliver",
        "triangles of the mesh are very flat: results near them are poor",
        "shape, 4 sqrt(3) area over the sum of squared sides, below {limit:g} (equilateral: 1)",
        "mesh more evenly there",
        0.05,
    ),
    _code(
        "nodes-not-merged",
        "pairs of nodes lie at the same place: parts that touch there are not joined",
        "distance below {limit:g} of the size of the mesh",
        "in gmsh, use BooleanFragments, or Coherence",
        1e-7,
    ),
    _code(
        "several-parts",
        "the shell is in parts that nothing joins",
        "more than one part",
        "join the parts, or describe them as bodies of their own",
    ),
    _code(
        "normals-disagree",
        "the normals of neighbours disagree: bottom and top of the lay-up, and the direction of "
        "pressures, change sides there",
        "any side at which they do",
        "turn the surface in gmsh, or set `flip = true` for its region",
    ),
    _code(
        "triangles-not-paired",
        'triangles stay although the description asks for `element = "quadrilateral"`',
        "share of triangles that stay beside others that stay, above {limit:g}; the cause is named",
        "make the quadrilaterals in gmsh (Recombine Surface), or a mesh of less sharp angles",
        0.25,
    ),
    _code(
        "link-distorts-section",
        "the load of a link deforms the walls of an open thin-walled end",
        "motion of the point along its load beyond that of the section, over the latter, in a load "
        "case or an attachment mode, above {limit:g}",
        "use the kind of link that the message names: `section` for closed sections and even "
        "twist, `average` for open sections with restrained warping; or a `rigid` one",
        0.1,
    ),
    _code(
        "cst-in-plane-bending",
        "few constant-strain triangles across a wall: it is far too stiff in bending in its own "
        "plane",
        'fewer than {limit:g} cells across a wall with `membrane = "cst"`',
        'use `membrane = "opt"`',
        4.0,
    ),
    _code(
        "dst-thick",
        "the paper's triangle does not converge where its sides are short for the thickness",
        '12 D / (Ds L^2) above {limit:g} with `plate = "dst"`',
        'use `plate = "dkmt"`',
        0.1,
    ),
    _code(
        "drilling-fictitious-flat",
        "a flat part keeps a motion without energy: all nodes turn about the normal",
        'any such part with `drilling = "fictitious"`',
        'use `drilling = "tie"`, `membrane = "opt"`, or fix the rotation at one node',
    ),
    _code(
        "zero-energy-modes",
        "modes without strain energy that are not rigid motions: mechanisms of the elements",
        "number of modes without strain energy above that of free rigid motions",
        "use the default elements",
    ),
    _code(
        "shell-triangles-warped",
        "triangles are too large for the thickness of a warped shell, whose surface twists or is "
        "curved in two directions: it is too stiff",
        "work of membranes on rotations of bending that the tilt of triangles turns into their "
        "planes, over that of the shell in a load case or mode, above {limit:g}",
        'use `element = "quadrilateral"` in `[mesh]`, or smaller cells',
        0.1,
    ),
    _code(
        "shell-quadrilaterals-warped",
        "quadrilaterals are too large for the thickness of a shell that is curved in two "
        "directions: it is too stiff",
        "work of membranes on rotations of bending that the tilt of cells turns into their planes, "
        "over that of the shell in a load case or mode, above {limit:g}",
        "use smaller cells; the message says how many times smaller",
        0.1,
    ),
    _code(
        "shell-mesh-coarse",
        "the mesh of a shell is coarse for its load factors, or for its frequencies",
        "estimated relative error of a first load factor, or of a frequency, above {limit:g}",
        "use smaller cells (`refine = 1` in `[mesh]`), or the value without the error",
        0.05,
    ),
    _code(
        "buckling-after-large-rotation",
        "the shell has turned far before it buckles: linear buckling assumes that it has not",
        "rotation at the first load factor above {limit:g} rad",
        "use the factor as an upper bound",
        0.1,
    ),
    _code(
        "buckles-in-plane",
        "the first buckling mode of a flat shell moves in its plane: a column, or supports that "
        "hold the rotation about the normal at one node only",
        "motion out of the plane below {limit:g} of the largest",
        "hold the plane at two nodes; `in_plane = false` leaves such modes out, as tables of "
        "plates do",
        0.1,
    ),
    _code(
        "few-digits",
        "the equations are ill-conditioned, as those of a very thin shell or open section",
        "residual or difference of work and energy (shell), work on rigid motions (section) above "
        "what round-off usually leaves",
        "trust displacements (shell) or shear stiffness (section) to fewer digits",
    ),
    _code(
        "laminate-unsymmetric",
        "a laminate couples stretching and bending: it warps when cured or heated",
        "B above {limit:g} of sqrt(A D)",
        "use a symmetric lay-up if the coupling is not wanted",
        1e-6,
    ),
    _code(
        "laminate-unbalanced",
        "a laminate shears when stretched",
        "A16 or A26 above {limit:g} of sqrt(A11 A66)",
        "use a balanced lay-up if the coupling is not wanted",
        1e-6,
    ),
    _code(
        "laminate-soft-core",
        "a soft core carries the transverse shear",
        "shear correction factor below {limit:g}",
        'keep `"energy-1d"` or `"energy-2x2"`; `"5/6"` would be too stiff',
        0.3,
    ),
)

SECTION_CODES = (
    _code(
        "unmerged-nodes",
        "pairs of nodes lie at the same place: the section has a slit there",
        "distance below {limit:g} of the size of the section, and below a hundredth of the "
        "shortest edge there",
        "merge them if the slit is not meant (gmsh: Coherence)",
        1e-7,
    ),
    _code(
        "sliver-elements",
        "cells of the mesh are very flat or crooked: stresses there are poor",
        "sine of the flattest angle below {limit:g}, or ratio of area scales below 0.02, or a "
        "cell longer than half of the section with a ratio of sides above 1e6",
        "mesh more evenly there",
        0.04,
    ),
    _code(
        "plies-not-resolved",
        "cells hold more than one ply: their stiffness is integrated across the face of the ply",
        "any such cell",
        "let mesh lines follow the plies",
    ),
    _code(
        "degree-1-locks",
        "linear elements are too stiff in bending and torsion by some per cent",
        "`mesh.degree = 1`",
        "leave `mesh.degree` at 2",
    ),
    _code(
        "nearly-incompressible",
        "a material hardly changes its volume: linear elements are too stiff, others lose digits",
        "bulk over shear modulus above {limit:g} (above 9 with `mesh.degree = 1`)",
        "use `mesh.degree = 2`, and a Poisson's ratio that is known",
        5000.0,
    ),
    _code(
        "ill-conditioned",
        "the equations of the warping are nearly singular; they were solved because of `allow`",
        "growth of a random load above {limit:g}",
        "check the mesh for parts that hardly hold together; compare with another mesh",
        1e14,
    ),
    _code(
        "stress-at-corner",
        "the least margin under `--loads` lies in a cell at a re-entrant corner, where stresses "
        "grow with every refinement",
        "more than {limit:g} deg of material around a node of the boundary",
        "give a distance, `--corner-distance`, such as a quarter of the wall; round the corner",
        195.0,
    ),
    _code(
        "coarse-mesh",
        "the estimated error of the stiffness is large, as that of a very thin twisted strip in "
        "shear and in bending in its plane",
        "estimate above {limit:g} of sqrt(K_ii K_jj)",
        "use `--accuracy`, a finer mesh (`density` of a shape), or `mesh.degree = 3`",
        0.05,
    ),
    _code(
        "model-not-computed",
        "the file of another code asks for a model that is not computed: trapeze effect, Vlasov's "
        "theory, damping, thermal expansion, recovery",
        "any such flag",
        "use the 6x6 stiffness and mass; run the other code for the rest",
    ),
    _code(
        "no-density",
        "a material of a file of another code has no density",
        "density 0",
        "give its density, or use the stiffness only",
    ),
    _code(
        "direction-reverses",
        "Cartesian layer directions change their sense inside cells of a round wall",
        "relative change of the stiffness by the sense in these cells above {limit:g}, or above "
        "`--accuracy`",
        "put a mesh line there, or give contour angles",
        1e-3,
    ),
    _code(
        "strongly-curved",
        "the section is large compared with the radius of its initial curvature",
        "shortest over reference fibre below {limit:g}",
        "model the part with solid elements",
        0.5,
    ),
    _code(
        "taper-neglected",
        "the section's size changes along the beam, which the stiffness does not contain",
        "estimated relative error of the stiffness above {limit:g}",
        "model the part with solid elements, or accept the estimate",
        1e-3,
    ),
    _code(
        "verification-differs",
        "`--verify`: K by the second method is another one",
        "difference above {limit:g} of sqrt(K_ii K_jj)",
        "report the section to the developers",
        1e-6,
    ),
    _code(
        "accuracy-not-met",
        "the next refinement would be too large: the accuracy asked for is not reached",
        "more than {limit:g} unknowns after the next refinement",
        "lower the accuracy, or use a better mesh",
        400000.0,
    ),
)

BLADE_CODES = (
    _code(
        "not-modelled",
        "the file has masses or stiffnesses that the stations do not have, or keys that windIO "
        "does not have",
        "any of them",
        "docs/blade.md says what they mean; correct misspelt keys",
    ),
    _code(
        "unlike-a-blade",
        "a size or a material that no blade has, as from other units",
        "length above 300 m, chord above 30 m or not 0.005 to 0.5 of the length, twist above "
        "45 deg, E below 1e5 Pa, density not 5 to 25000 kg/m3, sqrt(E / density) above 20 km/s",
        "use m, deg, Pa and kg/m3",
    ),
    _code(
        "rule-differs",
        "a rule of an anchor (width, offset, plane) and the numbers beside it give other places; "
        "the rule is used",
        "difference above {limit:g} of the arc",
        "remove the one that is wrong",
        0.01,
    ),
    _code(
        "no-room",
        "layers find no room between the two sides and were made thinner",
        "share of the area of the layers above {limit:g}",
        "check thicknesses and chord there; at a sharp trailing edge it is expected",
        0.02,
    ),
    _code(
        "differs-from-file",
        "mass or a stiffness of a station differs from `elastic_properties` of the file",
        "relative difference above {limit:g}",
        "docs/blade.md has the causes that were found; compare lay-up and matrices of the file",
        0.1,
    ),
)
