"""gmsh: scripts, mesh files and CAD files as plain arrays."""
