"""What a :class:`tolmc.Dimension` may follow between its limits, for scripts."""

from tolmc.tolerances.distributions import Beta, Distribution, Measured, Normal, Scipy, Triangular, Uniform

__all__ = ["Beta", "Distribution", "Measured", "Normal", "Scipy", "Triangular", "Uniform"]
