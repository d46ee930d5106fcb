"""What NumPy has for arrays of any shape, for one vector: in a tenth of the time, which is most of a twin's."""

import numpy as np


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b of vectors (3,), or of columns (3, n)."""
    (a_x, a_y, a_z), (b_x, b_y, b_z) = a, b
    return np.array([a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x])
