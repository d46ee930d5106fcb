"""Calls for workers in other processes, which must be able to import them."""

import os


def dies(value):
    if value == 3:
        os._exit(1)
    return value


def cannot(value):
    if value == 3:
        raise ArithmeticError("three")
    return value


def note(folder, value):
    (folder / str(value)).touch()
    return value
