"""The [dimensions] table of a study file -> nominal values, limits and distributions.

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

from tolmc import quantities, units
from tolmc.quantities import JOINT, SCALARS
from tolmc.study.fields import (
    Faults,
    check_names,
    in_section,
    place,
    short,
    suggestion,
    validated,
)
from tolmc.study.sections import DimensionSection, DimensionsSection
from tolmc.tolerances import fits
from tolmc.tolerances.csv_column import read_column
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Distribution, Measured, Normal, Scipy, Triangular, Uniform

_EXAMPLE = {
    "bearing_radius": '{ nominal = "20 mm", tolerance = "0.05 mm" }',
    "journal_radius": '{ nominal = "19.8 mm", tolerance = "0.05 mm" }',
    "half_length": '{ nominal = "20 mm" }',
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
    data_files : {relative path: content} of the files with measured values, after :meth:`tolerances`
    """

    def __init__(self, table: dict[str, Any], data_folder: Path) -> None:
        common = DimensionsSection.model_fields
        check_names(table, (*SCALARS, *common), "dimensions")
        given = validated(DimensionsSection, {name: table[name] for name in common if name in table}, "dimensions")
        self.data_folder = data_folder
        self.data_files: dict[str, bytes] = {}
        self.lot_size, self.written = given.lot_size, table
        sizes = {} if given.fit is None else _fit_sizes(given.fit)
        names = [name for name in SCALARS if name in table or name in sizes]
        self.entries = {name: _entry(name, table.get(name, {})) for name in names}
        self.limits = {name: _limits(name, entry, sizes.get(name)) for name, entry in self.entries.items()}
        self.sizes = sizes | {n: entry.diameter for n, entry in self.entries.items() if entry.diameter is not None}
        missing = [name for name in JOINT if name not in names]
        if missing:
            raise Faults(*(f"{place('dimensions', n)} is missing; add {n} = {_EXAMPLE[n]}." for n in missing))
        self.joint = {name: self._joint_nominal(name) for name in JOINT}

    def tolerances(self, scalars: dict[str, float], correlation: dict[str, Any]) -> Tolerances:
        """The dimensions of a scene with these ``scalars`` and the [correlation] table."""
        dimensions = [self._dimension(name, scalars[name]) for name in self.entries]
        pairs = _correlation(correlation, list(self.entries))
        with in_section("dimensions"):
            return Tolerances(dimensions, pairs or None, self.lot_size)

    def _joint_nominal(self, name: str) -> float:
        entry, limits = self.entries[name], self.limits[name]
        if entry.nominal is not None:
            return entry.nominal
        if limits is not None:
            return limits[0] + (limits[1] - limits[0]) / 2
        if entry.data is not None:
            return self._distribution(name).moments(None)[0]
        raise Faults(f"{place('dimensions', name, 'nominal')} is missing; {units.remedy('m')}.")

    def _dimension(self, name: str, nominal: float) -> Dimension:
        entry, limits = self.entries[name], self.limits[name]
        if name not in JOINT and entry.nominal is not None:
            written = self.written[name]
            written = short(written["nominal"] if isinstance(written, dict) else written)
            raise Faults(
                f"{place('dimensions', name, 'nominal')} = {written} does not belong here: the nominal value "
                "comes from the section that describes it. Leave it out."
            )
        if entry.tolerance is not None:
            limits = nominal + entry.tolerance[0], nominal + entry.tolerance[1]
        distribution = self._distribution(name)
        if limits is None and not distribution.stands_alone:
            idle = _given(entry, "distribution", *_ALL_OPTIONS, "lot_share", "lot_sd")
            if idle or name not in JOINT:
                raise Faults(f"{place('dimensions', name)} has no tolerance; add tolerance, or lower and upper.")
        options: dict[str, Any] = {"lower": limits[0], "upper": limits[1]} if limits is not None else {}
        options |= {"lot_share": entry.lot_share, "lot_sd": entry.lot_sd, "toleranced_size": self.sizes.get(name)}
        with in_section("dimensions", name, written=self.written.get(name, self.written.get("fit"))):
            return Dimension(name, nominal, distribution=distribution, **options)

    def _distribution(self, name: str) -> Distribution:
        entry = self.entries[name]
        word = entry.distribution or ("data" if entry.data is not None else "truncated_normal")
        kind = word if word in _OPTIONS else "scipy.stats"
        if kind == "scipy.stats" and not _is_in_scipy(word):
            known = [option for option in _OPTIONS if option != "scipy.stats"]
            raise Faults(
                f"{place('dimensions', name, 'distribution')} = {short(word)} is unknown{suggestion(word, known) or ';'} "
                f"Allowed: {', '.join(known)}, or the name of a continuous distribution of scipy.stats."
            )
        strange = [option for option in _given(entry, *_ALL_OPTIONS) if option not in _OPTIONS[kind]]
        if strange:
            raise Faults(
                f"{place('dimensions', name, strange[0])} means nothing for the distribution {word!r}; allowed with "
                f"it: {', '.join(_OPTIONS[kind]) or 'nothing more'}."
            )
        options = {option: getattr(entry, option) for option in _given(entry, *_OPTIONS[kind])}
        with in_section("dimensions", name, written=self.written.get(name)):
            if kind == "data":
                return self._measured(**options)
            if kind == "scipy.stats":
                return Scipy(word, _arguments(name, options.pop("arguments", {})), **options)
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


def _entry(name: str, raw: object) -> DimensionSection:
    table = raw if isinstance(raw, dict) else {"nominal": raw}
    return validated(DimensionSection, table, "dimensions", name, context=quantities.unit(name))


def _limits(name: str, entry: DimensionSection, fit_size: str | None) -> tuple[float, float] | None:
    """Limits that do not depend on the nominal value; None where there are none."""
    if (entry.lower is None) != (entry.upper is None):
        raise Faults(f"{place('dimensions', name)}: only one limit is given; give lower and upper, or a tolerance.")
    ways = _given(entry, "lower", "diameter", "tolerance") + (["fit"] if fit_size is not None else [])
    if len(ways) > 1:
        raise Faults(f"{place('dimensions', name)}: {' and '.join(ways)} both set its limits; leave one out.")
    size = fit_size if entry.diameter is None else entry.diameter
    if size is not None:
        with in_section("dimensions", name):
            dimension = Dimension.from_tolerance_class(name, size)
        return dimension.lower, dimension.upper
    return None if entry.lower is None else (entry.lower, entry.upper)


def _fit_sizes(designation: str) -> dict[str, str]:
    """Toleranced sizes of both radii."""
    with in_section("dimensions"):
        hole, shaft = fits.fit(designation).toleranced_sizes
    return {"bearing_radius": hole, "journal_radius": shaft}


def _is_in_scipy(word: str) -> bool:
    # Through the package, which loads scipy.stats (half a second) when it is first asked for.
    return isinstance(getattr(scipy.stats, word, None), scipy.stats.rv_continuous)


def _arguments(name: str, arguments: dict[str, Any]) -> dict[str, float]:
    """Arguments of a scipy.stats distribution: loc and scale in the dimension's unit, shapes plain numbers."""
    if not arguments:
        raise ValueError('it needs its arguments, such as arguments = { loc = "20 mm", scale = "0.01 mm" }')
    own = {"loc": quantities.unit(name), "scale": units.difference(quantities.unit(name))}
    return {key: units.read(value, own.get(key, "1")) for key, value in arguments.items()}


def _correlation(table: dict[str, Any], names: list[str]) -> dict[tuple[str, str], float]:
    """``[correlation] bearing_radius.journal_radius = 0.5`` -> {(bearing_radius, journal_radius): 0.5}."""
    check_names(table, names, "correlation")
    pairs = {}
    for first, row in table.items():
        if not isinstance(row, dict):
            raise Faults(f"{place('correlation', first)} = {short(row)}: expected {first}.other_dimension = number.")
        check_names(row, names, "correlation", first)
        for second, value in row.items():
            with in_section("correlation", first, second):
                pairs[first, second] = units.read(value, "1")
    return pairs
