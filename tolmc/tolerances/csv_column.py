"""A column of numbers from a CSV file, read so that no other column and no other notation can pass for it."""

from __future__ import annotations

import csv
import json
import re
from io import StringIO

import numpy as np

from tolmc.encoding import decoded
from tolmc.mechanism.checks import choice

SEPARATORS = (",", ";", "\t", "|")
DECIMALS = (".", ",")

_DECIMAL_COMMA = 'say decimal = "," (with separator = ";" where semicolons part the columns)'


def read_column(
    content: bytes, name: str, column: str, *, separator: str | None = None, decimal: str = "."
) -> np.ndarray:
    """Numbers of a column of a CSV file with a header line.

    Parameters
    ----------
    content : the file; UTF-8, or UTF-16 with a byte order mark
    name : what errors call the file
    column : its name in the header
    separator : between the columns; when not given a comma, or a semicolon where the decimal sign is a comma
    decimal : the decimal sign

    Returns
    -------
    numpy.ndarray (rows,)
        In the file's unit; empty lines are left out.

    Raises
    ------
    ValueError
        When the file is no such table; the message names the line, what stands there and what to do.
    """
    choice("decimal", decimal, DECIMALS)
    separator = choice("separator", separator or (";" if decimal == "," else ","), SEPARATORS)
    if separator == decimal:
        raise ValueError(f'{name}: separator and decimal are both ","; allowed: separator = ";" with decimal = ",".')
    rows = _rows(content, name, separator)
    place = _place(rows, name, column, separator)
    return np.array([_number(row[place], name, line, column, decimal) for line, row in rows[1:]])


def _rows(content: bytes, name: str, separator: str) -> list[tuple[int, list[str]]]:
    """Line number and fields of every row that is not empty, the header first; each has as many fields as the header."""
    try:
        text = StringIO(decoded(content), newline="")
        reader = csv.reader(text, delimiter=separator, skipinitialspace=True, strict=True)
        rows = [(reader.line_num, [field.strip() for field in row]) for row in reader if row]
    except (ValueError, csv.Error) as error:
        raise ValueError(f"{name} is not understood ({error}); allowed: a header line, then a row a part.") from None
    if len(rows) < 2:
        raise ValueError(f"{name} is not understood: it has no rows; allowed: a header line, then a row a part.")
    header = rows[0][1]
    for line, row in rows[1:]:
        if len(row) != len(header):
            raise ValueError(f"{name}, line {line}: {_miscount(row, header, separator)}")
    return rows


def _miscount(row: list[str], header: list[str], separator: str) -> str:
    """What a row with another number of fields than the header has, and what may be meant."""
    found = f"{separator.join(row)!r} has {len(row)} fields, the header {len(header)} ({', '.join(header)})"
    if len(row) < len(header):
        return f"{found}; complete the row or leave it out."
    other = _other_separator(header)
    if other is not None:
        decimal = ', and decimal = "," where the comma is its decimal sign' if separator == "," else ""
        return f"{found}; {_where_it_parts(other)}{decimal}."
    if not any(row[len(header) :]):
        end = "separator" if len(row) == len(header) + 1 else "separators"
        return f"{found}; remove the {end} at the end of the row, or end the header so too."
    if separator == "," and all(field.lstrip("+-").isdigit() for field in row if field):
        return f"{found}; where its comma is a decimal comma, {_DECIMAL_COMMA}."
    return f"{found}; name every column in the header, and quote a field that holds the separator."


def _other_separator(header: list[str]) -> str | None:
    """The mark that seems to part the columns of a header which another left whole."""
    return next((mark for mark in SEPARATORS if mark in header[0]), None) if len(header) == 1 else None


def _where_it_parts(mark: str) -> str:
    """What to say in the study; TOML writes a tab as JSON does."""
    return f"where {json.dumps(mark)} parts its columns, say separator = {json.dumps(mark)}"


def _place(rows: list[tuple[int, list[str]]], name: str, column: str, separator: str) -> int:
    header = rows[0][1]
    if header.count(column) > 1:
        raise ValueError(f"{name} has {header.count(column)} columns {column!r}; give each a name of its own.")
    if column not in header:
        other = _other_separator(header)
        remedy = f" Remedy: {_where_it_parts(other)}." if other else ""
        raise ValueError(f"{name} has no column {column!r}; allowed: {', '.join(header)}.{remedy}")
    # A first column without a name is an index; any other is what is left of a number at its decimal comma.
    unnamed = next(
        (k for k, title in enumerate(header) if k and not title and any(row[k] for _, row in rows[1:])), None
    )
    if unnamed is not None:
        raise ValueError(
            f"{name}: column {unnamed + 1} has values and no name; name it in the header. Where a decimal comma parts a "
            f"number in two, {_DECIMAL_COMMA}."
        )
    return header.index(column)


_NUMBER = {
    sign: re.compile(rf"[+-]?(?:[0-9]+(?:{re.escape(sign)}[0-9]*)?|{re.escape(sign)}[0-9]+)(?:[eE][+-]?[0-9]+)?")
    for sign in DECIMALS
}


def _number(text: str, name: str, line: int, column: str, decimal: str) -> float:
    if _NUMBER[decimal].fullmatch(text):
        return float(text.replace(decimal, "."))
    other = DECIMALS[1 - DECIMALS.index(decimal)]
    remedy = f"say decimal = {other!r}" if _NUMBER[other].fullmatch(text) else "correct the row or leave it out"
    raise ValueError(
        f"{name}, line {line}, column {column!r} holds {text!r}, which is no number with the decimal sign {decimal!r}; "
        f"{remedy}."
    )
