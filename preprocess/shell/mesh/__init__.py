"""Surface meshes: cells, groups, axes, refinement."""
