"""Motions whose loads or drive swing: an entry of their own, so that others do not carry what they do not have."""

from __future__ import annotations

from tolmc.kernels.jit import kernel
from tolmc.kernels.one_sided import circle, engine, equations, exact, general_swinging, symmetric_swinging

_ROUNDS = {
    (is_exact, is_general, rk4): engine.build(
        equations.build(exact if is_exact else circle, general_swinging if is_general else symmetric_swinging, True),
        rk4,
    )
    for is_exact in (False, True)
    for is_general in (False, True)
    for rk4 in (False, True)
}
_CIRCLE, _CIRCLE_4 = _ROUNDS[False, False, False], _ROUNDS[False, False, True]
_CIRCLE_ANY, _CIRCLE_ANY_4 = _ROUNDS[False, True, False], _ROUNDS[False, True, True]
_EXACT, _EXACT_4 = _ROUNDS[True, False, False], _ROUNDS[True, False, True]
_EXACT_ANY, _EXACT_ANY_4 = _ROUNDS[True, True, False], _ROUNDS[True, True, True]


@kernel
def integrate(raw, given, steps, duration, most, accuracy, out, counts, record, events, exact, general, rk4):
    """As :func:`engine.integrate`, always with friction; a symmetric body's loads do not swing, its drive does."""
    if exact is None:
        if general is None:
            if rk4 is None:
                _CIRCLE(raw, given, steps, duration, most, accuracy, out, counts, record, events)
            else:
                _CIRCLE_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        elif rk4 is None:
            _CIRCLE_ANY(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        else:
            _CIRCLE_ANY_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    elif general is None:
        if rk4 is None:
            _EXACT(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        else:
            _EXACT_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    elif rk4 is None:
        _EXACT_ANY(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    else:
        _EXACT_ANY_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
