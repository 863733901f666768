"""From meshes and materials to modal packages: needs the FEniCSx stack."""
