"""From modal packages to motion: needs NumPy, h5py and SciPy only."""
