"""From scenes to numbers: the only gate into the kernels."""
