"""What a command says on standard error besides what it is doing."""

import re


def complaints(stderr: str) -> list[str]:
    """Its lines but for those of long work, which end with its seconds: where kernels are compiled first it takes minutes."""
    return [line for line in stderr.splitlines() if not re.search(r", \d+ s$", line)]
