"""The [dimensions] table of a study file -> nominal values, limits and distributions.

bearing_diameter = "40 ±0.05 mm"                                          as drawn; also "40 +0.1/-0.2 mm", "⌀40 H7"
bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }             symmetric
journal_radius = { nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"] }  lower and upper deviation
half_length    = { lower = "19.9 mm", upper = "20.1 mm" }                 limits; the nominal is their middle
bearing_radius = { diameter = "40 H7" }                                   ISO 286 class of the diameter
fit            = "40 H7/d9"                                               both radii
journal_radius = { data = "rings.csv", column = "d", unit = "0.5 mm" }    measured (here: diameters in mm)
                   separator = ";", decimal = ","                         in it, for files of other countries
mass           = { tolerance = "5 g", distribution = "uniform" }          any other scalar; nominal from its section
"""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Any

import scipy

from tolmc import units
from tolmc.quantities import JOINT, SCALARS
from tolmc.study.drawing import MODEL_NAMES, model_name, size
from tolmc.study.fields import (
    Faults,
    OwnUnit,
    check_names,
    choices,
    in_section,
    place,
    short,
    validated,
)
from tolmc.study.sections import DimensionSection, DimensionsSection
from tolmc.tolerances import fits
from tolmc.tolerances.csv_column import read_column
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Distribution, Measured, Normal, Scipy, Triangular, Uniform

_EXAMPLE = {
    "bearing_radius": 'bearing_diameter = "40 ±0.05 mm"',
    "journal_radius": 'journal_diameter = "39.6 ±0.05 mm"',
    "half_length": 'bearing_length = "40 mm"',
}

# What a dimension's table may say beside its limits, for each distribution.
_OPTIONS = {
    "truncated_normal": ("cp", "cpk", "mean", "shift"),
    "normal": ("cp", "cpk", "mean", "shift"),
    "uniform": (),
    "triangular": ("mode",),
    "beta": ("alpha", "beta"),
    "scipy.stats": ("arguments", "truncated"),
    "data": ("data", "column", "unit", "separator", "decimal", "method", "bandwidth"),
}
_ALL_OPTIONS = tuple(dict.fromkeys(option for options in _OPTIONS.values() for option in options))
_NAMED = {"uniform": Uniform, "triangular": Triangular, "beta": Beta}


class DimensionsTable:
    """A [dimensions] table, checked against itself; what depends on the rest of the study comes after.

    Parameters
    ----------
    table : the table as read
    data_folder : folder of the measured values that it names

    Attributes
    ----------
    joint : {name: nominal value, m} of the three dimensions of the joint
    words : {name: what the study calls it}
    data_files : {relative path: content} of the files with measured values, after :meth:`tolerances`
    """

    def __init__(self, table: dict[str, Any], data_folder: Path) -> None:
        common = DimensionsSection.model_fields
        check_names(table, (*MODEL_NAMES, *SCALARS, *common), "dimensions")
        given = validated(DimensionsSection, {name: table[name] for name in common if name in table}, "dimensions")
        self.data_folder = data_folder
        self.data_files: dict[str, bytes] = {}
        self.lot_size, self.table = given.lot_size, table
        sizes = {} if given.fit is None else _fit_sizes(given.fit)
        words = dict(zip(sizes, sizes, strict=True)) | _written_names(table)
        self.words = {name: words[name] for name in SCALARS if name in words}
        self.entries = {name: _entry(word, table.get(word, {})) for name, word in self.words.items()}
        self.limits = {name: self._limits(name, sizes.get(name)) for name in self.entries}
        self.sizes = sizes | {n: entry.diameter for n, entry in self.entries.items() if entry.diameter is not None}
        missing = [name for name in JOINT if name not in self.words]
        if missing:
            raise Faults(*(f"{place('dimensions', name)} is missing; add {_EXAMPLE[name]}." for name in missing))
        self.joint = {name: self._joint_nominal(name) for name in JOINT}

    def tolerances(self, scalars: dict[str, float], correlation: dict[str, Any]) -> Tolerances:
        """The dimensions of a scene with these ``scalars`` and the [correlation] table."""
        dimensions = [self._dimension(name, scalars[name]) for name in self.entries]
        pairs = self._correlation(correlation)
        with in_section("dimensions"):
            return Tolerances(dimensions, pairs or None, self.lot_size)

    def _correlation(self, table: dict[str, Any]) -> dict[tuple[str, str], float]:
        """``[correlation] bearing_radius.journal_radius = 0.5`` -> {(bearing_radius, journal_radius): 0.5}."""
        names = tuple(dict.fromkeys((*self.words.values(), *self.words)))
        check_names(table, names, "correlation")
        pairs = {}
        for first, row in table.items():
            if not isinstance(row, dict):
                raise Faults(
                    f"{place('correlation', first)} = {short(row)}: expected {first}.other_dimension = number."
                )
            check_names(row, names, "correlation", first)
            for second, value in row.items():
                with in_section("correlation", first, second):
                    coefficient = units.read(value, "1")
                if not -1.0 <= coefficient <= 1.0:
                    field = place("correlation", first, second)
                    raise Faults(f"{field} = {short(value)}: expected a correlation from -1 to 1.")
                pairs[model_name(first), model_name(second)] = coefficient
        return pairs

    def _joint_nominal(self, name: str) -> float:
        entry, limits = self.entries[name], self.limits[name]
        if entry.nominal is not None:
            return entry.nominal
        if limits is not None:
            return limits[0] + (limits[1] - limits[0]) / 2
        if entry.data is not None:
            return self._distribution(name).moments(None)[0]
        raise Faults(f"{self._place(name, 'nominal')} is missing; {units.remedy('m')}.")

    def _dimension(self, name: str, nominal: float) -> Dimension:
        entry, limits = self.entries[name], self.limits[name]
        if name not in JOINT and entry.nominal is not None:
            written = self.written(name)
            written = short(written.get("nominal", written.get("size")) if isinstance(written, dict) else written)
            raise Faults(
                f"{self._place(name, 'nominal')} = {written} does not belong here: the nominal value "
                "comes from the section that describes it. Leave it out."
            )
        if entry.tolerance is not None:
            limits = nominal + entry.tolerance[0], nominal + entry.tolerance[1]
        distribution = self._distribution(name)
        if limits is None and not distribution.stands_alone:
            idle = _given(entry, "distribution", *_ALL_OPTIONS, "lot_share", "lot_sd")
            if idle or name not in JOINT:
                raise Faults(f"{self._place(name)} has no tolerance; add tolerance, or lower and upper.")
        options: dict[str, Any] = {"lower": limits[0], "upper": limits[1]} if limits is not None else {}
        options |= {"lot_share": entry.lot_share, "lot_sd": entry.lot_sd, "toleranced_size": self.sizes.get(name)}
        options["is_drawn"] = self.words[name] in MODEL_NAMES
        with in_section("dimensions", self.words[name], written=self.written(name)):
            return Dimension(name, nominal, distribution=distribution, **options)

    def _limits(self, name: str, fit_size: str | None) -> tuple[float, float] | None:
        """Limits that do not depend on the nominal value; None where there are none."""
        entry = self.entries[name]
        if (entry.lower is None) != (entry.upper is None):
            raise Faults(f"{self._place(name)}: only one limit is given; give lower and upper, or a tolerance.")
        ways = _given(entry, "lower", "diameter", "tolerance") + (["fit"] if fit_size is not None else [])
        if len(ways) > 1:
            raise Faults(f"{self._place(name)}: {' and '.join(ways)} both set its limits; leave one out.")
        toleranced = fit_size if entry.diameter is None else entry.diameter
        if toleranced is not None:
            with in_section("dimensions", self.words[name]):
                dimension = Dimension.from_tolerance_class(name, toleranced)
            return dimension.lower, dimension.upper
        return None if entry.lower is None else (entry.lower, entry.upper)

    def written(self, name: str) -> Any:
        """What stands in the table for the dimension."""
        return self.table.get(self.words[name], self.table.get("fit"))

    def _place(self, name: str, *field: str) -> str:
        return place("dimensions", self.words[name], *field)

    def _distribution(self, name: str) -> Distribution:
        entry = self.entries[name]
        word = entry.distribution or ("data" if entry.data is not None else "truncated_normal")
        kind = word if word in _OPTIONS else "scipy.stats"
        if kind == "scipy.stats" and not _is_in_scipy(word):
            known = [option for option in _OPTIONS if option != "scipy.stats"]
            raise Faults(
                f"{self._place(name, 'distribution')} = {short(word)} is unknown"
                + choices(word, known, f"{', '.join(known)}, or the name of a continuous distribution of scipy.stats")
                + "."
            )
        strange = [option for option in _given(entry, *_ALL_OPTIONS) if option not in _OPTIONS[kind]]
        if strange:
            raise Faults(
                f"{self._place(name, strange[0])} means nothing for the distribution {word!r}; allowed with "
                f"it: {', '.join(_OPTIONS[kind]) or 'nothing more'}."
            )
        options = {option: getattr(entry, option) for option in _given(entry, *_OPTIONS[kind])}
        if kind == "beta" and len(options) < len(_OPTIONS[kind]):
            lacking = next(option for option in _OPTIONS[kind] if option not in options)
            raise Faults(
                f"{self._place(name, lacking)} is missing; a beta distribution has two shape parameters > 0, such as "
                "alpha = 2, beta = 3."
            )
        with in_section("dimensions", self.words[name], written=self.table.get(self.words[name])):
            if kind == "data":
                return self._measured(**options)
            if kind == "scipy.stats":
                return Scipy(word, _arguments(self.words[name], options.pop("arguments", {})), **options)
            if kind in _NAMED:
                return _NAMED[kind](**options)
            return Normal(**options, truncated=kind == "truncated_normal")

    def _measured(self, *, data: str | None = None, column: str | None = None, unit: float | None = None, **options):
        if data is None or column is None or unit is None:
            raise ValueError('measured values need data = "file.csv", column = "name" and unit = "mm"')
        relative = _relative(data)
        path = self.data_folder / relative
        try:
            content = path.read_bytes()
        except OSError as error:
            raise ValueError(f"data file {path} cannot be read: {error.strerror}; check its path") from None
        self.data_files[str(relative)] = content
        notation = {name: options.pop(name) for name in ("separator", "decimal") if name in options}
        return Measured(read_column(content, f"data file {path}", column, **notation) * unit, **options)


def _relative(data: str) -> PurePosixPath:
    """The path of a data file. A run keeps a copy of the file at the same relative path, so it must not leave the folder."""
    if "\\" in data or any(ord(sign) < 32 for sign in data):  # "\b" in double quotes is one sign already
        raise ValueError(
            f"data = {short(data)} has a backslash (which starts an escape in double quotes); write / instead"
        )
    relative = PurePosixPath(data)
    if relative.is_absolute() or ".." in relative.parts or ":" in data:
        raise ValueError(f"data = {short(data)} must lie in the study's folder; give a relative path without '..'")
    return relative


def _given(entry: DimensionSection, *names: str) -> list[str]:
    return [name for name in names if getattr(entry, name) is not None]


def _written_names(table: dict[str, Any]) -> dict[str, str]:
    """{name: what the table calls it} of the dimensions that it has."""
    found: dict[str, str] = {}
    for word in table:
        name = model_name(word)
        if name in found:
            both = " and ".join((found[name], word))
            raise Faults(f"{place('dimensions', word)}: {both} are the same dimension; leave one out.")
        if name in SCALARS:
            found[name] = word
    return found


def _entry(name: str, raw: object) -> DimensionSection:
    table = raw if isinstance(raw, dict) else {"size": raw} if isinstance(raw, str) else {"nominal": raw}
    if isinstance(table.get("size"), str):
        table = _with_size(name, table)
    return validated(DimensionSection, table, "dimensions", name, context=OwnUnit.of(name))


def _with_size(name: str, table: dict[str, Any]) -> dict[str, Any]:
    """The table with what its text ``size`` says in fields of their own."""
    text = table["size"]
    try:
        found = size(name, text)
    except ValueError as error:
        raise Faults(f"{place('dimensions', name)} = {short(text)}: {error}.") from None
    double = [field for field in found if field in table]
    if double:
        raise Faults(f"{place('dimensions', name, double[0])} is in size = {short(text)} already; leave one out.")
    return {**found, **{field: value for field, value in table.items() if field != "size"}}


def _fit_sizes(designation: str) -> dict[str, str]:
    """Toleranced sizes of both radii."""
    with in_section("dimensions", "fit"):
        hole, shaft = fits.fit(designation).toleranced_sizes
    return {"bearing_radius": hole, "journal_radius": shaft}


def _is_in_scipy(word: str) -> bool:
    # Through the package, which loads scipy.stats (half a second) when it is first asked for.
    return isinstance(getattr(scipy.stats, word, None), scipy.stats.rv_continuous)


def _arguments(name: str, arguments: dict[str, Any]) -> dict[str, float]:
    """Arguments of a scipy.stats distribution: loc and scale in the dimension's unit, shapes plain numbers."""
    if not arguments:
        raise ValueError('it needs its arguments, such as arguments = { loc = "20 mm", scale = "0.01 mm" }')
    own = OwnUnit.of(name)
    readers = {"loc": own.read, "scale": own.read_difference}
    return {key: readers[key](value) if key in readers else units.read(value, "1") for key, value in arguments.items()}
