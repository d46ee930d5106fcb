"""Standard output and error as the surroundings have them: closed, without Unicode, or gone before all is said."""

from __future__ import annotations

import codecs
import logging
import os
import sys

#: What signs are written as where an encoding lacks them; the rest becomes "?".
_SIGNS = {
    "−": "-", "–": "-", "—": "-", "±": "+-", "≤": "<=", "≥": ">=", "≈": "~", "·": "*", "×": "x", "→": "->", "←": "<-",
    "∞": "inf", "°": "deg", "²": "^2", "µ": "u", "μ": "u", "⌀": "dia", "½": "1/2", "√": "sqrt", "’": "'", "“": '"', "”": '"',
    "α": "alpha", "β": "beta", "χ": "chi", "ψ": "psi", "λ": "lambda", "σ": "sigma", "Ω": "Omega", "ω": "omega", "Δ": "Delta",
    "θ": "theta", "φ": "phi", "π": "pi",
}  # fmt: skip


def _spelled(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(_SIGNS.get(sign, "?") for sign in signs), error.end


def prepare() -> None:
    """Make both streams fit for any text: what their encoding lacks is spelled out, and what is closed takes and forgets."""
    codecs.register_error("tolmc", _spelled)
    # Pictures have settings of their own: what Matplotlib finds wrong with the user's is not for who asked for a run.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    # A file opened later must not get the number of a closed stream, to which a library may still write.
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(descriptor)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None or stream.closed:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - as long as the process
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="tolmc")


def reader_is_gone() -> bool:
    """Whether the program that read our output has ended (``tolmc ... | head``); output is forgotten from then on."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        # Else the interpreter would try once more at its end, and complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return True
    return False
