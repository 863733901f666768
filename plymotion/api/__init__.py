"""What `import plymotion` offers in Python: cases, runs, sweeps, sections (docs/python.md).

Nothing is imported here; plymotion/__init__.py imports a name when it is asked for.
"""
