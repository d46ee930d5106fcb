"""What the report says about a run: everything that its templates show, from the run directory."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from tolmc import quantities, units
from tolmc.allocation.explored import Explored
from tolmc.analysis.failure_sources import failure_sources
from tolmc.analysis.from_samples import first_order, rank_correlation
from tolmc.analysis.smoothness import held_out_shares, rough
from tolmc.errors import InputError
from tolmc.report import notes, rubbing
from tolmc.report.answer import Answer, answer, question
from tolmc.report.curves import HEIGHT, WIDTH, Panel, panels
from tolmc.report.explorer.content import explorer_content, parts_of
from tolmc.report.losses import losses
from tolmc.report.pictures import PICTURES, embedded
from tolmc.runs.contact_law import CONTACT_LAW
from tolmc.runs.directory import RunDirectory
from tolmc.runs.exact_subset import EXACT_SECTION
from tolmc.runs.record import RunDirectoryError
from tolmc.runs.until import looks_of
from tolmc.statistics.capability import ALL_REQUIREMENTS, capability
from tolmc.statistics.contact_law import by_restitution, law_of_requirements
from tolmc.statistics.looks import Looks
from tolmc.statistics.outcomes import ANY_REQUIREMENT, without_value
from tolmc.statistics.section_effect import section_of_requirements
from tolmc.statistics.summary import count_statuses, summarise_requirements
from tolmc.statistics.tolerance_intervals import ToleranceInterval, tolerance_interval
from tolmc.study.sections import TARGET_YIELD
from tolmc.study.study import Study
from tolmc.tables.dimensions import constants_table, dimensions_table
from tolmc.tables.influence import contributions_table, failures_table, indices_table
from tolmc.tables.life import life_table, shown_in
from tolmc.tables.next_changes import next_changes_table
from tolmc.tables.outputs import budget_table, contact_law_table, outputs_table, statuses_table
from tolmc.tables.requirements import capability_table, requirements_table
from tolmc.tables.stackup import accelerated_table, stackup_table
from tolmc.tables.table import Table
from tolmc.text import phrases

#: Samples from which contributions are estimated, a balanced part of a Sobol' run: ranks of many more cost seconds.
EXAMINED = 2**15

#: Outputs for which there is room where the study has no requirement.
FOREMOST = ("tilt_angle", "contact_force_D_max", "contact_force_E_max")

#: Tables that a run leaves or may leave, with the columns of their index.
TABLES = {
    "summary.csv": "output",
    "stackup.csv": ["output", "quantity"],
    "sobol_indices.csv": ["output", "dimension"],
    "yields.csv": "requirement",
    "one_at_a_time.csv": "dimension",
    "next_changes.csv": None,
    "life.csv": "hours",
}


def report_content(run: RunDirectory) -> dict:
    """Names and values for the templates; ``tables`` is a list of :class:`tolmc.tables.table.Table`."""
    content, study, record = _Content(run), run.study(), run.record
    pictures = embedded(run.path)
    return {
        "title": " ".join(record["title"].split()),
        "study": study,
        "record": record,
        "finished": record["finished"][:10],
        "sampling": phrases.SAMPLINGS[study.sampling],
        "question": question(study),
        "answer": content.answer(),
        "tables": content.tables(),
        "explorer": content.explorer(sum(len(picture) for _, picture in pictures.values())),
        "losses": losses(content.samples, study.scene.duration),
        "relations": notes.relations(study),
        "rubbing": rubbing.of_rubbing(study, content.summary),
        "life": rubbing.of_life(run.path),
        "curves": content.curves(),
        "width": WIDTH,
        "height": HEIGHT,
        "pictures": pictures,
        "further": [name for name in pictures if name not in PICTURES],
        "trust": content.trust(),
        "limits": notes.limits(study),
        "reproduction": notes.reproduction(study, record),
        "commands": notes.commands(study),
        "facts": notes.facts(record),
    }


@dataclass(frozen=True)
class _Content:
    """The run's tables and estimates, each computed once."""

    run: RunDirectory

    @cached_property
    def study(self) -> Study:
        return self.run.study()

    @cached_property
    def columns(self) -> list[str]:
        return self.run.read(rows=1).column_names

    @property
    def inputs(self) -> list[str]:
        return [dimension.name for dimension in self.study.tolerances.varied]

    @property
    def foremost(self) -> tuple[str, ...]:
        return tuple(self.study.specification) or FOREMOST

    @property
    def drawn(self) -> dict:
        """How the rows were drawn, as the estimators take it."""
        has_lots = any(dimension.between_lots for dimension in self.study.tolerances.varied)
        return {"sampling": self.study.sampling, "lot_size": self.study.tolerances.lot_size if has_lots else 1}

    @cached_property
    def looks(self) -> Looks | None:
        """Where a sequential run looked; None for one of a fixed number of samples."""
        study = self.run.sequential_study()
        return None if study is None else looks_of(study)

    @property
    def level(self) -> dict:
        """Confidence of an interval: higher at each look of a sequential run, so that all looks together hold at 95 %."""
        return {} if self.looks is None else {"confidence": self.looks.look_confidence}

    @property
    def judged(self) -> dict:
        """What samples are held against, and what a loss of contact means then."""
        return {"specification": self.study.specification, "on_contact_loss": self.study.on_contact_loss}

    @property
    def watches_contact(self) -> bool:
        """Whether contact forces were computed of motions that start on the wall, so that a loss of contact was seen."""
        has_forces = any(quantities.output(name).group == "statistics" for name in self.columns)
        return has_forces and not self.study.scene.motion.is_free

    @property
    def target(self) -> float:
        if self.study.target is not None:
            return self.study.target
        given = self.study.allocation.get("target_yield", TARGET_YIELD)
        try:
            return units.read(given, "1")
        except ValueError as error:
            raise InputError(f"[allocation] target_yield = {given!r}: {error}.") from None

    @cached_property
    def samples(self) -> pd.DataFrame:
        """All rows of what requirements and failures need."""
        wanted = dict.fromkeys([*self.inputs, *self.study.specification, "contact_loss_time", "status"])
        return self.run.read(columns=[name for name in wanted if name in self.columns]).to_pandas()

    @cached_property
    def examined(self) -> pd.DataFrame:
        """The first rows, of everything."""
        return self.run.read(rows=EXAMINED).to_pandas()

    @cached_property
    def summary(self) -> pd.DataFrame | None:
        return self._table("summary.csv")

    @cached_property
    def shares(self) -> pd.DataFrame:
        shares = summarise_requirements(self.samples, **self.judged, **self.drawn, **self.level)
        settings: dict[str, Any] = {"target": self.target, **self.judged, **self.drawn, **self.level}
        terms = []
        if (exact := self._kept(EXACT_SECTION)) is not None:
            terms.append(
                section_of_requirements(self.samples, self.samples.iloc[: len(exact)], exact, shares, **settings)
            )
        if (law := self._kept(CONTACT_LAW)) is not None:
            followed = by_restitution(law)
            first = self.samples.iloc[: min(len(frame) for frame in followed.values())]
            terms.append(law_of_requirements(first, followed, shares, **settings))
        return shares.join(terms)

    @cached_property
    def statuses(self) -> pd.DataFrame:
        return count_statuses(self.samples, **self.drawn, **self.level)

    def _kept(self, name: str) -> pd.DataFrame | None:
        """The samples that another model ran too; None where the run has none."""
        path = self.run.path / name
        if not path.exists():
            return None
        try:
            return pd.read_parquet(path)
        except (OSError, ValueError) as error:
            raise RunDirectoryError(
                f"{path} is damaged: {error}. Delete it to leave it out of the report, or resume the run."
            ) from None

    @cached_property
    def capability(self) -> pd.DataFrame:
        """A row a requirement, and one for all where there are several; empty without any."""
        found = capability(self.samples, **self.judged, **self.drawn, **self.level)
        return found if len(self.study.specification) > 1 else found.drop(index=ALL_REQUIREMENTS, errors="ignore")

    @cached_property
    def failure_sources(self) -> pd.DataFrame:
        found = failure_sources(self.samples, inputs=self.inputs, lot_size=self.drawn["lot_size"], **self.judged)
        return self._as_shown(found)

    @cached_property
    def indices(self) -> pd.DataFrame:
        return self._as_shown(first_order(self.examined, **self._of_examined))

    def _as_shown(self, table: pd.DataFrame) -> pd.DataFrame:
        """The table with its dimensions named as people are shown them; their values stay the model's."""
        return table.rename(index=self.study.tolerances.shown_names, level="dimension")

    @property
    def _of_examined(self) -> dict:
        outputs = quantities.responses_among(self.columns)
        return {"inputs": self.inputs, "outputs": outputs, **self.drawn}

    def answer(self) -> Answer:
        return answer(
            self.study,
            shares=self.shares,
            capability=self.capability,
            indices=self.indices if self.inputs else None,
            failure_sources=self.failure_sources if self.inputs else None,
            target=self.target,
            watches_contact=self.watches_contact,
            warning=phrases.too_few_computed(self.statuses),
        )

    def trust(self) -> list[str]:
        sentences = [notes.of_sampling(self.study.samples, **self.drawn)]
        if self.looks is not None:
            sentences.append(notes.of_looks(self.looks, self.run.record.get("stopped_at")))
        if self.summary is not None:
            sentences.append(
                notes.of_integration(self.run.record["plan"], self.summary, self.run.record.get("pilot", ""))
            )
        of_contact = notes.of_contact(
            self.shares, is_watched=self.watches_contact, on_contact_loss=self.study.on_contact_loss
        )
        of_impacts = notes.of_impacts(self.summary) if self.summary is not None else ""
        return [*sentences, *of_contact, *(sentence for sentence in (of_impacts, self._of_jumps()) if sentence)]

    def _of_jumps(self) -> str:
        """Which outputs impacts make jump, and what that spoils; empty without any."""
        if "free_share" not in self.columns:
            return ""
        shares = held_out_shares(self.examined, inputs=self.inputs, outputs=quantities.responses_among(self.columns))
        words = phrases.jumps(rough(shares), phrases.spoiled_by_jumps(self.study.sampling))
        return f"Jumps: {words}" if words else ""

    def tables(self) -> list[Table]:
        """Those that have something to say."""
        return [table for table in self._tables() if table]

    def _tables(self) -> Iterator[Table]:
        yield dimensions_table(self.study)
        yield constants_table(self.study)
        if self.study.specification:
            yield requirements_table(self.study, self.shares, self.capability, self.target, self._table("yields.csv"))
            yield capability_table(self.capability, self._tolerance_intervals())
        if (changes := self._table("next_changes.csv")) is not None:
            yield next_changes_table(self.study, changes, self.target)
        if self.inputs:
            directions = self._as_shown(rank_correlation(self.examined, **self._of_examined))
            are_correlated = self.study.tolerances.correlation is not None
            yield contributions_table(self.indices, directions, are_correlated=are_correlated)
            shown_names = self.study.tolerances.shown_names
            yield failures_table(self.failure_sources, [shown_names[name] for name in self.inputs])
        if self.summary is not None:
            yield outputs_table(self.summary, self.study.specification)
            yield budget_table(self.summary)
            yield contact_law_table(self.summary)
        yield statuses_table(self.statuses)
        if (life := self._table("life.csv")) is not None:
            yield life_table(life, self.study, shown_in(life))
        if (stackup := self._table("stackup.csv")) is not None:
            yield stackup_table(stackup)
            yield accelerated_table(stackup)
        if (indices := self._table("sobol_indices.csv")) is not None:
            yield indices_table(self._as_shown(indices), self.foremost)

    def _tolerance_intervals(self) -> dict[str, ToleranceInterval]:
        return {
            name: tolerance_interval(
                self.samples[name].mask(without_value(self.samples, name, **self.judged)),
                share=TARGET_YIELD,
                **self.drawn,
            )
            for name in self.study.specification
        }

    def curves(self) -> list[list[Panel]]:
        curves = self._table("one_at_a_time.csv")
        return [] if curves is None else panels(self._as_shown(curves), self.foremost, self.study.specification)

    def explorer(self, pictures: int) -> dict | None:
        """For the part that answers what other tolerances would do, beside pictures of so many bytes.

        None where the run has no polynomials for it.
        """
        path = self.run.path / "surrogate.json"
        if self.summary is None or not path.exists():
            return None
        try:
            explored = Explored.of_json(path.read_text(encoding="utf-8"))
        except (ValueError, KeyError, TypeError) as error:
            raise RunDirectoryError(
                f"{path} is damaged: {error}. Delete it to leave it out of the report, or make the report anew with: "
                f"tolmc report {self.run.path}"
            ) from None
        samples = self.run.read(columns=self.inputs, rows=parts_of(self.study, pictures)).to_pandas()
        return explorer_content(self.study, explored, samples, self.summary, self.target, of_section=self._of_section())

    def _of_section(self) -> str:
        """What the exact section makes of the requirements, where that is another verdict; "" elsewhere."""
        return str(self.shares["section"].get(ANY_REQUIREMENT, "")) if "section" in self.shares else ""

    def _table(self, name: str) -> pd.DataFrame | None:
        path = self.run.path / name
        if not path.exists():
            return None
        try:
            table = pd.read_csv(path) if path.stat().st_size > 1 else pd.DataFrame()
            return table if TABLES[name] is None else table.set_index(TABLES[name])
        except (ValueError, KeyError) as error:
            raise RunDirectoryError(
                f"{path} is damaged: {error}. Restore it, or delete it to leave it out of the report."
            ) from None
