"""A study, checked as a whole: what is drawn, what is simulated, what is asked."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w

from tolmc import quantities
from tolmc.errors import StudyError
from tolmc.mechanism.scene import Scene
from tolmc.quantities import JOINT, MASS_AND_CENTER
from tolmc.shown import Shown
from tolmc.study.build import study_fields
from tolmc.study.derived import Derived
from tolmc.study.fields import Faults, validated
from tolmc.study.sections import LifeSection, MonteCarloSection
from tolmc.study.until import Until
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Tolerances

__all__ = ["Study", "StudyError", "Until"]

_SOBOL_ACCURACY = 1e-8


@dataclass(frozen=True, eq=False)
class Study(Shown):
    """A study, checked as a whole; SI units.

    Attributes
    ----------
    name : str
        The file's name without its ending.
    title : str
    scene : Scene
        With the nominal dimensions.
    tolerances : Tolerances
        Dimensions with their distributions, correlation and lots.
    specification : {output: {"min": limit, "max": limit}}
    samples, sampling, seed, workers, accuracy, step, method, formulation, on_contact_loss, project_energy, halving, outputs
        As :func:`tolmc.run` and :func:`tolmc.simulate_many` take them.
    model_error : bool
        Whether some samples run by other models too, for the model's term of the error budget.
    until : Until or None
        Where given, sampling stops when this interval is narrow enough, and ``samples`` is the largest number.
    derived : tuple of Derived
        The study's own outputs.
    target : float or None
        Share of the parts that have to keep every limit; None where [specification] does not say.
    life : LifeSection or None
        The [life] table, for :mod:`tolmc.runs.life`.
    allocation : mapping
        The [allocation] table as written, for :mod:`tolmc.allocation.allocate`.
    inertia_law : {"origin", "centroid", "cylinder"}
        What stays when mass or centre of mass vary: the inertia about O, that about the centre of mass, or the cylinder's
        shape (its inertia about the centre of mass is then proportional to the mass).
    source : str
        Text of the file.
    data_files : {relative path: content}
        Files of measured values that the study names.
    """

    name: str
    title: str
    scene: Scene
    tolerances: Tolerances
    specification: Mapping[str, Mapping[str, float]]
    samples: int
    sampling: str
    seed: int
    workers: int
    accuracy: float | None
    step: float | None
    method: str
    formulation: str
    on_contact_loss: str
    project_energy: bool
    halving: bool
    model_error: bool
    outputs: tuple[str, ...] | None
    until: Until | None
    derived: tuple[Derived, ...]
    target: float | None
    life: LifeSection | None
    allocation: Mapping[str, Any]
    inertia_law: Literal["origin", "centroid", "cylinder"]
    source: str
    data_files: Mapping[str, bytes]

    def __post_init__(self) -> None:
        self.introduce()

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__dict__.update(state)
        self.introduce()

    def introduce(self) -> None:
        """Make the study's own outputs known by their names, which another study may have had for something else."""
        for output in self.derived:
            quantities.derive(output.row)

    def __repr__(self) -> str:
        varied = ", ".join(dimension.name for dimension in self.tolerances.varied) or "nothing"
        limited = ", ".join(self.specification) or "nothing"
        drawn = f"{self.samples:,} {self.sampling} samples, seed {self.seed}"
        return f"<Study {self.title!r}: {drawn}; varied: {varied}; limited: {limited}>"

    @classmethod
    def of_file(cls, content: dict[str, Any], source: str, *, name: str, data_folder: str | Path) -> Study:
        """From the content of a study file, whose text is ``source``.

        Raises
        ------
        Faults
            With everything that is wrong in the first section that has faults.
        """
        fields = study_fields(content, Path(data_folder))
        fields["title"] = fields["title"] or name
        return cls(name=name, source=source, **fields)

    @classmethod
    def from_dict(cls, content: Mapping[str, Any], *, name: str = "study", data_folder: str | Path = ".") -> Study:
        """From what a study file holds, as tables within a mapping.

        Parameters
        ----------
        content : as TOML would give it; NumPy's numbers and arrays too, and None for what is not given
        name : of the study, where it has no title, and of its run directory
        data_folder : folder to which the names of data files are relative

        Raises
        ------
        StudyError
            The message names the field, its value, what is allowed and what to do.
        """
        try:
            source = tomli_w.dumps(_plain(content))
            return cls.of_file(tomllib.loads(source), source, name=name, data_folder=data_folder)
        except TypeError as error:
            raise StudyError(
                f"{name}: {error}. A study holds texts, numbers, true and false, lists and tables."
            ) from None
        except Faults as faults:
            raise StudyError("\n".join(f"{name}: {sentence}" for sentence in faults.sentences)) from None

    @cached_property
    def sha256(self) -> str:
        """Hash of the study file and of the data files it names."""
        digest = hashlib.sha256(self.source.encode())
        for name, content in sorted(self.data_files.items()):
            digest.update(hashlib.sha256(name.encode()).digest() + hashlib.sha256(content).digest())
        return digest.hexdigest()

    def with_derived(self, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The columns with the study's own outputs, which follow from them."""
        return {**columns, **{output.name: output.values(columns, self.scene.scalars) for output in self.derived}}

    @property
    def integrates(self) -> bool:
        """Whether any output needs a motion."""
        return self.outputs is None or not set(self.outputs) <= set(quantities.GEOMETRY)

    @property
    def integration_accuracy(self) -> float | None:
        """The accuracy asked for; where it and the step are left open, an order below what sampling leaves.

        The intervals of a Sobol' run of 10^5 samples are down to some 1e-7 of a mean; those of independent ones are a thousand
        times wider. It must not depend on the number of samples: a longer run begins with the shorter one's.
        """
        if self.accuracy is not None or self.step is not None or self.sampling != "sobol":
            return self.accuracy
        return _SOBOL_ACCURACY

    def with_inertia(self, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The columns with the inertia about O that follows from them, J = J_C + m (|c|^2 I - c c^T).

        Parameters
        ----------
        columns : mapping from names in quantities.SCALARS to (n,) arrays, SI units

        Returns
        -------
        dict
            The same, and ``inertia_xx`` ... where mass or centre of mass vary and the body is not given about O.
        """
        if self.inertia_law == "origin" or not any(name in columns for name in MASS_AND_CENTER):
            return dict(columns)
        nominal = self.scene.scalars
        mass, *center = (np.asarray(columns.get(name, nominal[name]), float) for name in MASS_AND_CENTER)
        growth = mass / self.scene.body.mass if self.inertia_law == "cylinder" else 1.0
        square = sum(c * c for c in center)
        derived = {}
        for i, j in combinations_with_replacement(range(3), 2):
            shift = mass * (square * (i == j) - center[i] * center[j])
            derived[f"inertia_{'xyz'[i]}{'xyz'[j]}"] = growth * self.scene.body.centroidal_inertia[i, j] + shift
        rows = np.broadcast_shapes(*(np.shape(column) for column in columns.values()))
        return {**columns, **{name: np.broadcast_to(values, rows).copy() for name, values in derived.items()}}

    def with_fit(self, designation: str) -> Study:
        """The study with bore and journal in another ISO 286 fit, such as "40 H11/d11"; distributions keep their shape.

        Raises
        ------
        ValueError
            When the fit is none, or leaves no clearance between the middles of its zones.
        """
        fit = fits.fit(designation)
        classes = dict(zip(JOINT, fit.toleranced_sizes, strict=False))
        dimensions = [d.in_class(classes[d.name]) if d.name in classes else d for d in self.tolerances.dimensions]
        nominal = {d.name: d.nominal for d in dimensions if d.name in classes}
        if nominal["bearing_radius"] <= nominal["journal_radius"]:
            low, high = (f"{1e3 * end:.4g}" for end in fit.clearance)
            raise ValueError(
                f"{designation} leaves a clearance of {low} to {high} mm on the diameter: nothing can tilt in it"
            )
        tolerances = replace(self.tolerances, dimensions=tuple(dimensions))
        return replace(self, scene=self.scene.replaced(**nominal), tolerances=tolerances)

    def replaced(self, *, samples: int | None = None, seed: int | None = None, workers: int | None = None) -> Study:
        """The study with another number of samples, seed or number of workers; None keeps its own.

        A number of samples given here is the number drawn: it takes the place of ``until`` too.
        """
        given: dict[str, Any] = {"samples": samples, "seed": seed, "workers": workers}
        given = {name: value for name, value in given.items() if value is not None}
        try:
            validated(MonteCarloSection, given, "monte_carlo")
        except Faults as faults:
            raise StudyError("\n".join(faults.sentences)) from None
        return replace(self, **given, until=None if "samples" in given else self.until)


def _plain(value: Any) -> Any:
    """A value as TOML has it: numbers and lists without NumPy, tables without what is None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items() if part is not None}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return str(value) if isinstance(value, Path) else value
