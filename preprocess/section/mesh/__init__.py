"""Meshes of sections: cells, nodes, checks, refinement."""
