"""Common parts of all file formats: HDF5, datasets, identity, checks of arrays, materials."""
