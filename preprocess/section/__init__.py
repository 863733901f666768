"""Cross-section analysis: 6x6 stiffness and mass of a beam of any material, and its stresses."""
