"""From dimensions with tolerances to samples of them."""

from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.draw import sample

__all__ = ["Dimension", "Tolerances", "sample"]
