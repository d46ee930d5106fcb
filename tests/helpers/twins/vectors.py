"""What NumPy has for arrays of any shape, for one vector: in a tenth of the time, which is most of a twin's."""

import numpy as np


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b of vectors (3,)."""
    a_x, a_y, a_z = a.tolist()
    b_x, b_y, b_z = b.tolist()
    return np.array([a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x])


def cross_matrix(a: np.ndarray) -> np.ndarray:
    """(3, 3): what a x is to columns."""
    x, y, z = a.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
