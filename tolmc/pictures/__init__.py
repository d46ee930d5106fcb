"""Figures from frames."""

#: Outputs whose distribution is drawn.
DISTRIBUTIONS = (
    "tilt_angle", "effective_radius", "contact_force_D_max", "contact_force_E_max",
    "impacts_D", "impacts_E", "impulse_D_max", "impulse_E_max",
)  # fmt: skip
