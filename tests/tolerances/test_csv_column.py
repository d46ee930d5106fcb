"""A column of a CSV file: the right numbers in every notation, or an error that names the line and the remedy."""

import numpy as np
import pytest

from tolmc.tolerances.csv_column import read_column

SEMICOLONS = "bore;chamfer\n40,3920;41,5084\n40,3868;41,4939\n"


def read(text: str | bytes, column: str = "bore", **notation) -> list[float]:
    content = text if isinstance(text, bytes) else text.encode()
    return read_column(content, "bores.csv", column, **notation).tolist()


@pytest.mark.parametrize(
    ("text", "notation"),
    [
        ("bore,chamfer\n40.3920,41.5084\n40.3868,41.4939\n", {}),
        ("chamfer, bore\r\n41.5084, 40.3920\r\n\r\n41.4939, 4.03868e1\r\n", {}),
        ('bore,note\n40.3920,"good, all in all"\n40.3868,""', {}),
        (",bore\n0,40.3920\n1,40.3868\n", {}),
        ("bore,chamfer,\n40.3920,41.5084,\n40.3868,41.4939,\n", {}),
        (SEMICOLONS, {"decimal": ","}),
        (SEMICOLONS, {"decimal": ",", "separator": ";"}),
        ("bore\n40,3920\n40,3868\n", {"decimal": ","}),
        ('bore,chamfer\n"40.3920","41"\n"40.3868","41"\n', {}),
        ("bore\tchamfer\n40.3920\t1\n40.3868\t1\n", {"separator": "\t"}),
        ("bore\n40.3920\n40.3868\n".encode("utf-8-sig"), {}),
        ("bore\n40.3920\n40.3868\n".encode("utf-16"), {}),
    ],
)
def test_every_notation_gives_the_same_numbers(text, notation):
    assert read(text, **notation) == [40.3920, 40.3868]


@pytest.mark.parametrize(
    ("text", "notation", "words"),
    [
        ("bore,chamfer\n40.3920,41.5084,\n", {}, ["line 2", "3 fields, the header 2", "end of the row"]),
        ("bore,chamfer\n40.3920,41.5\n40.3868,41.4,7.5,2\n", {}, ["line 3", "4 fields", "name every column"]),
        ("bore\n40,3920\n40,3868\n", {}, ["line 2", "decimal comma", 'decimal = ","']),
        ("bore,chamfer\n40,3920,41,5084\n", {}, ["line 2", 'decimal = ","']),
        ("bore,\n40,3920\n40,3868\n", {}, ["column 2", "no name", 'decimal = ","']),
        (SEMICOLONS, {"separator": ";"}, ["line 2", "'40,3920'", "decimal = ','"]),
        ("bore;chamfer\n40.392;41.5\n", {}, ["no column 'bore'", 'separator = ";"']),
        ("bore\tchamfer\n40.392\t41.5\n", {}, ["no column 'bore'", 'separator = "\\t"']),
        (SEMICOLONS, {}, ["line 2", 'separator = ";", and decimal = ","']),
        ("bore;\n40,392;\n40,386;\n", {}, ["line 2", 'separator = ";", and decimal = ","']),
        ("bore\tchamfer\n40,392\t41,5\n", {"decimal": ",", "separator": ";"}, ['separator = "\\t"']),
        ("bore,chamfer\n40.3920,41.5,,\n", {}, ["line 2", "remove the separators at the end"]),
        ('bore\n"40,3920"\n"40,3868"\n', {}, ["line 2", "'40,3920'", "decimal = ','"]),
        ("bore\n40.392\n40.391\n", {"decimal": ","}, ["line 2", "decimal = '.'"]),
        ('bore\n"1,234.5"\n', {}, ["line 2", "'1,234.5'", "no number"]),
        ("bore,chamfer\n40.3920\n", {}, ["line 2", "1 fields", "complete the row"]),
        ("bore,chamfer\n40.3920,1\n,2\n", {}, ["line 3", "holds ''"]),
        ("bore\n40.39\nnan\n", {}, ["line 3", "'nan'"]),
        ("bore\n4_0\n", {}, ["'4_0'"]),
        ("bore,bore\n40.39,41.5\n", {}, ["2 columns 'bore'"]),
        ('bore\n"40.39\n40.40\n', {}, ["not understood"]),
        ("bore\n", {}, ["no rows"]),
        ("", {}, ["no rows"]),
        ("bore,Ø\n40.39,1\n".encode("latin-1"), {}, ["UTF-8"]),
        ("bore\n40.39\n".encode("utf-16-le"), {}, ["UTF-16", "save it as UTF-8"]),
        ("bore\n1\n", {"separator": ",", "decimal": ","}, ['separator = ";"']),
        ("bore\n1\n", {"separator": "x"}, ["separator = 'x'"]),
    ],
)
def test_what_could_be_misread_is_refused_with_line_and_remedy(text, notation, words):
    with pytest.raises(ValueError) as refusal:
        read(text, **notation)
    for word in words:
        assert word in str(refusal.value)


def test_numbers_of_any_usual_form():
    assert read("bore\n+1.\n.5\n-2e-3\n7\n") == [1.0, 0.5, -2e-3, 7.0]
    assert np.isinf(read("bore\n1e999\n")[0])  # refused as a measured value, which has to be finite
