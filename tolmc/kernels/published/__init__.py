"""The paper's own formulation: its equations, and motions by them."""

from tolmc.kernels.published.equations import (  # noqa: F401
    accelerations,
    applied_wrench,
    body_matrix,
    constraint_moment,
    constraints,
    contact_forces,
    generalised_forces,
    mass_matrix,
    rotation,
    solve,
    start,
    torque_power,
    total_energy,
    transformation,
)
from tolmc.kernels.published.motion import (  # noqa: F401
    DIVERGED,
    OK,
    SINGULAR_MAXIMUM_TILT,
    SINGULAR_PSI,
    SINGULAR_THETA,
    advance,
    failure,
    integrate,
    project,
    retract,
    sample_steps,
    separation,
)
