"""Errors that the person who gave the input can put right; the command line prints them without a traceback."""


class InputError(ValueError):
    """An input that cannot be used; the message names it, its value, what is allowed and what to do."""


class ClusterError(InputError):
    """A cluster that cannot be reached or used, or that gave up a block."""


class StudyError(InputError):
    """A study that cannot be used; the message names the file, the field and the remedy."""
