"""Solids: parts from CAD files and meshes, by three-dimensional elasticity."""
