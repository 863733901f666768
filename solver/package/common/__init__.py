"""What all file formats share: HDF5, datasets, identity, checks of arrays, materials."""
