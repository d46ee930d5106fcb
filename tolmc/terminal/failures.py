"""What the operating system refused, with its place and a remedy."""

from __future__ import annotations

import errno

_REMEDIES = {
    ("ENOENT", "ENOTDIR", "EISDIR", "EEXIST", "ENOTEMPTY", "ELOOP", "EINVAL"): "Check the path",
    ("EACCES", "EPERM", "EROFS"): "Choose a place where you may write, or ask for the right to",
    ("ENOSPC", "EDQUOT", "EFBIG"): "Free space there, or choose another disk",
    ("ENAMETOOLONG",): "Choose a shorter name",
    ("EMFILE", "ENFILE"): "Close other programs, or raise the limit of open files",
    ("ENOMEM",): "Close other programs, or use fewer workers",
    ("EBUSY", "ETXTBSY", "EAGAIN"): "Close what else uses it, then try again",
    (
        "ESTALE",
        "ETIMEDOUT",
        "ENETDOWN",
        "ENETUNREACH",
        "EHOSTDOWN",
        "EHOSTUNREACH",
        "EREMOTEIO",
        "ENOTCONN",
    ): "Check the connection to the drive, then try again",
}
_BY_NUMBER = {
    getattr(errno, name): remedy for names, remedy in _REMEDIES.items() for name in names if hasattr(errno, name)
}


def sentence(error: OSError) -> str:
    """Where it happened, what the system says of it, and what to do."""
    where = error.filename2 or error.filename
    said = (error.strerror or str(error) or type(error).__name__).rstrip(".")
    remedy = _BY_NUMBER.get(error.errno, "Check the disk and the path")
    return f"{said}. {remedy}." if where is None else f"{where}: {said}. {remedy}."
