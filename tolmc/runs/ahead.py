"""The kernel that a run needs second, compiled beside its first."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from tolmc.runs.exact_subset import on_exact_section, says_something_new
from tolmc.runs.integrate import study_features
from tolmc.simulation.ahead import compiled_ahead
from tolmc.simulation.features import Features
from tolmc.simulation.outputs import wants_forces
from tolmc.study.study import Study


def kernel_ahead(study: Study) -> AbstractContextManager[None]:
    """A context in which a study's second worker, where it has one, compiles its second kernel, where it has one."""
    features = _second(study) if study.workers > 1 and study.integrates and study.formulation == "slope" else None
    if features is None:
        return nullcontext()
    method = "rk8" if study.method == "auto" else study.method
    return compiled_ahead(features, method, wants_forces(study.outputs))


def _second(study: Study) -> Features | None:
    features = study_features(study)
    if features.alone:  # there is no other kernel
        return None
    if features.one_sided:
        return features
    return on_exact_section(features) if says_something_new(study) else None
