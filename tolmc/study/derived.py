"""Outputs of a study's own: expressions of dimensions and outputs with units, such as "800 mm * sin(tilt_angle)".

simpleeval walks the expression and knows arithmetic and the functions below, nothing else: no attribute, index, text or
comparison. Pint says once what the expression measures; samples are then evaluated as numbers in SI units.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from simpleeval import InvalidExpression, SimpleEval

from tolmc import quantities
from tolmc.quantities import KINDS, Output
from tolmc.study.drawing import MODEL_NAMES
from tolmc.study.fields import Faults, choices, place, short, suggestion, validated
from tolmc.study.sections import OutputSection

FUNCTIONS = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": np.arctan2, "sqrt": np.sqrt, "abs": np.abs, "exp": np.exp, "log": np.log, "hypot": np.hypot,
    "min": np.minimum, "max": np.maximum,
}  # fmt: skip
_OPERATORS = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow, ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
_NODES = (ast.UnaryOp, ast.BinOp, ast.Call, ast.Name, ast.Constant)

_WORD = r"[^\W\d_]+(?:(?:\*\*|\^)\d)?"
_NUMBER = re.compile(
    rf"(?<![\w.])(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:\s*(?P<unit>%|°|{_WORD}(?:[/·]{_WORD})*))?(?![\w.])"
)
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_LONGEST = 500


@dataclass(frozen=True)
class Derived:
    """An output that follows from dimensions and other outputs.

    Attributes
    ----------
    name : what it is called
    expression : with a name for each number
    constants : {name: value} of the numbers, SI units
    names : the dimensions and outputs that it needs
    row : what it measures and what people call it
    """

    name: str
    expression: str
    constants: Mapping[str, float]
    names: tuple[str, ...]
    row: Output

    def values(self, columns: Mapping[str, np.ndarray], scalars: Mapping[str, float]) -> np.ndarray:
        """Its values for columns of dimensions and outputs, SI units; a scalar that does not vary comes from ``scalars``."""
        known = {}
        for name in self.names:
            of_model = MODEL_NAMES.get(name, name)
            value = columns[of_model] if of_model in columns else scalars[of_model]
            known[name] = value * quantities.of(name).times
        rows = np.broadcast_shapes(*(np.shape(column) for column in columns.values()))
        with np.errstate(all="ignore"):
            return np.broadcast_to(_evaluated(self.expression, {**self.constants, **known}), rows).astype(float)

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs that it needs."""
        return tuple(name for name in self.names if name in quantities.OUTPUTS)


def read_outputs(table: Mapping[str, Any]) -> tuple[Derived, ...]:
    """The [outputs] table, each output made known to :mod:`tolmc.quantities`; Faults where one cannot be used."""
    return tuple(_output(name, entry) for name, entry in table.items())


def _output(name: str, entry: object) -> Derived:
    if (
        not _NAME.fullmatch(name)
        or (quantities.is_known(name) and not quantities.is_derived(name))
        or name in FUNCTIONS
    ):
        raise Faults(
            f"{place('outputs', name)} cannot be called so: a name is of small letters, digits and _, and none that a "
            "dimension, output or function has. Choose another."
        )
    section = validated(OutputSection, entry if isinstance(entry, dict) else {"value": entry}, "outputs", name)
    try:
        expression, names, constants = _parsed(section.value)
        kind = _kind(expression, names, constants, section.unit)
    except ValueError as error:
        raise Faults(f"{place('outputs', name)} = {short(section.value)}: {error}.") from None
    of_geometry = {word for word in names if word in quantities.OUTPUTS} <= set(quantities.GEOMETRY)
    label = section.label or name.replace("_", " ").capitalize()
    row = Output(name, kind, label, group="derived", settled="at start" if of_geometry else "at end")
    quantities.derive(row)
    numbers = {word: float(value.to_base_units().magnitude) for word, value in constants.items()}
    return Derived(name, expression, numbers, names, row)


def _parsed(text: str) -> tuple[str, tuple[str, ...], dict[str, Any]]:
    """The expression with a name for each number, the dimensions and outputs in it, and the numbers with their units."""
    if len(text) > _LONGEST:
        raise ValueError(f"it is longer than {_LONGEST} characters; write it shorter")
    constants: dict[str, Any] = {}

    def named(match: re.Match) -> str:
        word = f"number_{len(constants)}"
        constants[word] = _quantity(match["number"], match["unit"] or "")
        return word

    expression = _NUMBER.sub(named, text)
    return expression, _names(expression, set(constants)), constants


def _names(expression: str, constants: set[str]) -> tuple[str, ...]:
    """The dimensions and outputs in an expression, all of whose parts are allowed."""
    try:
        tree = ast.parse(expression.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError('it is no expression; write one such as "800 mm * sin(tilt_angle)", a power as **') from None
    known = (*MODEL_NAMES, *quantities.SCALARS, *quantities.OUTPUTS)
    names: dict[str, None] = {}
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp | ast.UnaryOp) and type(node.op) not in _OPERATORS:
            raise ValueError(f"{type(node.op).__name__} is no arithmetic; allowed: + - * / and ** for a power")
        if isinstance(node, ast.Name) and id(node) in called:
            _allow(node.id, FUNCTIONS, "function")
        elif isinstance(node, ast.Name) and node.id not in constants:
            _allow(node.id, known, "dimension or output")
            names[node.id] = None
        elif isinstance(node, ast.keyword) or (isinstance(node, ast.expr) and not isinstance(node, _NODES)):
            raise ValueError("only arithmetic, functions, numbers with units, dimensions and outputs are allowed")
        elif isinstance(node, ast.Constant):
            raise ValueError("a text or word in it is no number; write numbers with their unit, such as 800 mm")
    return tuple(names)


def _allow(word: str, allowed: Any, what: str) -> None:
    if word not in allowed:
        if len(allowed) < 20:
            raise ValueError(f"{word!r} is no {what}{choices(word, allowed)}")
        raise ValueError(f"{word!r} is no {what}{suggestion(word, allowed) or ';'} 'tolmc explain' lists them")


def _evaluated(expression: str, names: Mapping[str, Any]) -> Any:
    evaluator = SimpleEval(operators=_OPERATORS, functions=FUNCTIONS, names=dict(names))
    return evaluator.eval(expression)


@cache
def _registry():
    import pint

    return pint.UnitRegistry()


def _quantity(number: str, unit: str) -> Any:
    import pint

    try:
        return _registry().Quantity(
            float(number), unit.replace("°", "degree").replace("·", "*").replace("%", "percent")
        )
    except (pint.PintError, AttributeError, ArithmeticError):
        raise ValueError(f"the unit {unit!r} behind {number} is unknown; write one such as mm, N or deg") from None


def _kind(expression: str, names: tuple[str, ...], constants: Mapping[str, Any], unit: str | None) -> str:
    """What the expression measures, a name in :data:`tolmc.quantities.KINDS`: that of ``unit`` where it is given."""
    import pint

    registry = _registry()
    ones = {name: registry.Quantity(1.0, quantities.unit(name)) for name in names}
    try:
        with np.errstate(all="ignore"):
            found = registry.Quantity(1.0, "") * _evaluated(expression, {**constants, **ones})
    except pint.DimensionalityError as error:
        raise ValueError(
            f"its units do not go together: {error}; add and subtract only what measures the same, and bring it there by a "
            "factor with its unit, such as 800 mm * sin(tilt_angle)"
        ) from None
    except (InvalidExpression, pint.PintError, TypeError, ArithmeticError) as error:
        raise ValueError(f"it cannot be evaluated: {error}") from None
    asked = found if unit is None else _quantity("1", unit)
    if asked.dimensionality != found.dimensionality:
        raise ValueError(f"it is in {found.to_base_units().units:~P}, not in {unit}; change unit, or leave it out")
    base = asked.to_base_units().units
    alike = [name for name, kind in KINDS.items() if kind.unit == unit]
    alike += [name for name, kind in KINDS.items() if registry.Unit(kind.unit.replace("°C", "K")) == base]
    alike += [name for name, kind in KINDS.items() if _same(registry, kind.unit, asked)]
    if not alike:
        raise ValueError(f"it is in {base:~P}, which no quantity here has; make it one of: {', '.join(KINDS)}")
    return alike[0]


def _same(registry: Any, unit: str, asked: Any) -> bool:
    return unit not in ("1", "rad") and registry.Unit(unit.replace("°C", "K")).dimensionality == asked.dimensionality
