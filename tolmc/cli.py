"""The command line. Everything heavy is imported by the command that needs it: `tolmc --help` answers at once."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from pathlib import Path
from typing import cast

import click

from tolmc import __version__
from tolmc.commands.init import KINDS, write_example
from tolmc.errors import InputError
from tolmc.terminal import failures, streams

_FILE = click.Path(path_type=Path)
# Codes with which a command ends that has done its work: no tolerances shown to do, too few samples computed to stand for the
# parts. 1 is what the system refused, 2 what was asked wrongly, 130 a stop.
_NOT_SHOWN, _TOO_FEW_COMPUTED = 3, 4


class _Commands(click.Group):
    """Commands in the order of work; what a person can put right ends as one line on stderr."""

    def list_commands(self, ctx):
        return list(self.commands)

    def invoke(self, ctx):
        try:
            return super().invoke(ctx)
        except InputError as error:
            _stop(error, 2)
        except BrokenPipeError as error:
            if streams.reader_is_gone():
                sys.exit(1)
            _stop(error, 1)
        except OSError as error:
            _stop(error, 1)
        except KeyboardInterrupt as interrupt:
            _stop(interrupt, 130)


def _stop(error: BaseException, code: int) -> None:
    said = failures.sentence(error) if isinstance(error, OSError) else str(error)
    lines = [said or "Stopped.", *getattr(error, "__notes__", ())]
    click.echo("\n".join(lines) if code == 130 else "Error: " + "\n".join(lines), err=True)
    sys.exit(code)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="tolmc")
def main() -> None:
    """Tolerance choice for a rotating body in a bearing with large clearance.

    A study file (TOML) describes the joint, its tolerances, the body, its loads and the start of the motion.

    Codes at the end: 0 done; 1 refused by the system; 2 asked wrongly; 3 allocate: no tolerances shown to do; 4 run and report:
    fewer than 90 % of the samples could be computed; 130 stopped.
    """
    streams.prepare()
    # The user's choice is for windows; a name that Matplotlib does not know would stop its import.
    os.environ["MPLBACKEND"] = "agg"
    # The packages leave some hundred thousand objects that stay: looking for garbage among them took a run 0.3 s, and its end
    # another 0.3 s.
    gc.set_threshold(5_000)
    atexit.register(gc.freeze)


@main.command()
@click.argument("name", type=_FILE, metavar="NAME.toml")
@click.option("--kind", type=click.Choice(KINDS), default=KINDS[0], show_default=True, help="What the study is of.")
def init(name: Path, kind: str) -> None:
    """Write a commented study to begin with."""
    write_example(name, kind)
    click.echo(f"Written: {name}. Next: tolmc check {name}, then tolmc run {name}")


@main.command()
@click.argument("study", type=_FILE)
def check(study: Path) -> None:
    """Say what STUDY is understood to mean.

    Dimensions, clearance, loads and start; what will be computed and about how long that takes. Computes nothing else.
    """
    from tolmc.commands.check import check_study

    check_study(study)


@main.command()
@click.argument("field", required=False)
@click.option("--markdown", "as_markdown", is_flag=True, help="The whole study file, as Markdown.")
def explain(field: str | None, as_markdown: bool) -> None:
    """Say what FIELD of a study means and may be.

    FIELD is a field, table, dimension or output, such as body.mass or contact_force_D_max; without one: what there is.
    """
    from tolmc.commands import explain as study_file

    click.echo(study_file.markdown() if as_markdown else study_file.explain(field), nl=not as_markdown)


@main.command()
def schema() -> None:
    """Print the JSON schema of a study, for editors.

    They complete and check a study from it: tolmc schema > study.schema.json, and as the study's first line
    #:schema study.schema.json
    """
    import json

    from tolmc.commands.explain import study_schema

    click.echo(json.dumps(study_schema(), indent=1, ensure_ascii=False))


@main.command()
@click.argument("study", type=_FILE, required=False)
@click.option(
    "--samples", type=click.IntRange(min=1), help="Number of samples, in place of the study's and of its `until`."
)
@click.option("--seed", type=click.IntRange(min=0), help="Seed, in place of the study's.")
@click.option("--workers", type=click.IntRange(min=1), help="Parallel workers; the numbers do not depend on it.")
@click.option("--out", type=_FILE, help="Directory to write into.  [default: runs/<study name>]")
@click.option("--resume", type=_FILE, metavar="DIR", help="Go on with the stopped run in DIR.")
@click.option("--extend", type=click.IntRange(min=1), metavar="N", help="Add N samples to the finished run.")
@click.option("--cluster", metavar="ADDRESS", help="Compute on the Dask cluster at ADDRESS, such as tcp://host:8786.")
@click.option("--compare-section", is_flag=True, help="Run circle and exact section on the same samples and compare.")
@click.option("--brief", is_flag=True, help="Print the verdict, the requirements and the outputs with limits, no more.")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON, SI units.")
def run(
    study: Path | None,
    samples: int | None,
    seed: int | None,
    workers: int | None,
    out: Path | None,
    resume: Path | None,
    extend: int | None,
    cluster: str | None,
    compare_section: bool,
    brief: bool,
    as_json: bool,
) -> None:
    """Sample STUDY, integrate every sample, summarise.

    Writes samples.parquet, summary.csv and pictures. A run that was stopped goes on with --resume DIR; a finished
    one gets N more samples with --extend N --resume DIR. With `until` in its [monte_carlo] table a study is sampled
    until an interval is narrow enough.

    Ends with code 4 when fewer than 90 % of the samples could be computed: everything is written, and says so first.
    """
    if extend is not None and resume is None:
        raise click.UsageError("--extend adds samples to a finished run: name its directory with --resume DIR.")
    if resume is not None and not (samples is None and seed is None and out is None):
        raise click.UsageError("--samples, --seed and --out are settled in a run that is resumed; leave them out.")
    if resume is None and study is None:
        raise click.UsageError("name the STUDY file to run, or a directory with --resume.")
    if as_json and (brief or compare_section):
        raise click.UsageError("--json prints everything of the run; leave --brief and --compare-section out.")
    from tolmc.pictures.painters import painters

    shown = {"compare": compare_section, "brief": brief, "as_json": as_json}
    crew = {"workers": workers, "cluster": cluster}
    with painters():
        from tolmc.commands.run import resume_run, run_study

        if resume is not None:
            enough = resume_run(resume, shown, study=study, extend=extend or 0, **crew)
        else:
            enough = run_study(cast(Path, study), shown, samples=samples, seed=seed, out=out, **crew)
    if not enough:
        sys.exit(_TOO_FEW_COMPUTED)


@main.command()
@click.argument("study", type=_FILE)
@click.option("--out", type=_FILE, help="Picture to write.  [default: <study name>.png]")
def simulate(study: Path, out: Path | None) -> None:
    """Show the nominal motion of STUDY, with a picture."""
    from tolmc.commands.motions import simulate_study

    simulate_study(study, out=out)


@main.command()
@click.argument("directory", type=_FILE)
@click.option("--sample", type=click.IntRange(min=0), required=True, metavar="I", help="Number of the sample, from 0.")
@click.option("--out", type=_FILE, help="Picture to write.  [default: DIRECTORY/sample_I.png]")
def replay(directory: Path, sample: int, out: Path | None) -> None:
    """Show the motion of one sample of a run again.

    Its full trajectory, with a picture.
    """
    from tolmc.commands.motions import replay_sample

    replay_sample(directory, sample, out=out)


@main.command()
@click.argument("directory", type=_FILE)
def answers(directory: Path) -> None:
    """Show four answers of a run side by side.

    Worst case, root sum square, Monte Carlo and the accelerated estimate of the run in DIRECTORY. Also writes them there,
    with Sobol' indices and one-at-a-time curves, for the report to show.
    """
    from tolmc.commands.answers import answer_run

    answer_run(directory)


@main.command()
@click.argument("directory", type=_FILE)
def report(directory: Path) -> None:
    """Write a run as one self-contained HTML file.

    Ends with code 4 when fewer than 90 % of its samples could be computed: the report says so first.
    """
    from tolmc.commands.report import report_run

    if not report_run(directory):
        sys.exit(_TOO_FEW_COMPUTED)


@main.command()
@click.argument("first", type=_FILE)
@click.argument("second", type=_FILE)
@click.option("--out", type=_FILE, help="HTML file to write the comparison into.")
def compare(first: Path, second: Path, out: Path | None) -> None:
    """Compare two runs.

    What changed in the study, and every statistic and share with the interval of its difference.
    """
    from tolmc.commands.compare import compare_directories

    compare_directories(first, second, out=out)


@main.command()
@click.argument("study", type=_FILE)
@click.option(
    "--try", "tried", required=True, metavar="FITS", help="Such as 'H11/d11, H9/d9', or a range 'H11/a11-e11'."
)
@click.option("--samples", type=click.IntRange(min=1), help="Number of samples for each, in place of the study's.")
@click.option("--csv", type=_FILE, help="File to write the table into, SI units.")
def fits(study: Path, tried: str, samples: int | None, csv: Path | None) -> None:
    """Compare fits of bore and journal for STUDY.

    Runs STUDY with each fit on the same points: clearance, yield, the limited outputs and cost, side by side.
    """
    from tolmc.commands.fits import compare_fits

    compare_fits(study, tried, samples=samples, csv=csv)


@main.command()
@click.argument("study", type=_FILE)
@click.option("--out", type=_FILE, help="Directory to write into.  [default: runs/<study name>_allocation]")
def allocate(study: Path, out: Path | None) -> None:
    """Find the cheapest tolerances that do for STUDY.

    Ends with code 3 when the tolerances found could not be shown to meet them.
    """
    from tolmc.commands.allocate import allocate_study

    if not allocate_study(study, out=out).is_met:
        sys.exit(_NOT_SHOWN)


@main.command()
@click.argument("study", type=_FILE)
@click.option("--samples", type=click.IntRange(min=1), help="Number of parts, in place of the study's samples.")
@click.option("--seed", type=click.IntRange(min=0), help="Seed, in place of the study's.")
@click.option("--workers", type=click.IntRange(min=1), help="Parallel workers; the numbers do not depend on it.")
@click.option("--out", type=_FILE, help="Directory to write into.  [default: runs/<study name>_life]")
def life(study: Path, samples: int | None, seed: int | None, workers: int | None, out: Path | None) -> None:
    """Follow the wear of STUDY's joint over its running time.

    STUDY is a study file, or the directory of a run whose report then shows it. Clearance, forces, tilt and the share of the
    parts inside their limits against hours, and the hours after which too many break one. Started again, it goes on where it
    was stopped.
    """
    from tolmc.commands.life import life_study

    life_study(study, samples=samples, seed=seed, workers=workers, out=out)
