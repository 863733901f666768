"""Rotor blades: cross-sections, beam body and files of other codes from a windIO file."""
