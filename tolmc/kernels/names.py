"""Names of the entries, by which they are kept on disk: one for each choice of their parts."""

from __future__ import annotations


def integrate(formulation: str, method: str, *, load: bool, forces: bool) -> str:
    return _name("integrate", formulation, method, load=load, forces=forces)


def trace(formulation: str, method: str, *, load: bool) -> str:
    return _name("trace", formulation, method, load=load)


def observe(formulation: str, *, load: bool) -> str:
    return _name("observe", formulation, load=load)


def one_sided(**present: bool) -> str:
    return _name("one_sided", **present)


def start_from(formulation: str) -> str:
    return _name("start_from", formulation)


FROM_ANGLES, GAPS = "from_angles", "gaps"


def _name(*words: str, **present: bool) -> str:
    return "_".join((*words, *(word for word, is_present in present.items() if is_present))).replace(" ", "_")
