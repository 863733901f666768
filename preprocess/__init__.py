"""Preprocessor: modal packages from meshes and materials. Needs the FEniCSx stack."""
