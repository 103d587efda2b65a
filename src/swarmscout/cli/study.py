"""``swarmscout study``: run a study, or resume one that was interrupted."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

if TYPE_CHECKING:
    from swarmscout.studies.study import Study

__all__ = ["run_and_show", "study"]


def study(
    file: Annotated[Path, Parameter(name="STUDY")],
    /,
    *,
    jobs: Annotated[int | None, Parameter(show_default=False)] = None,
    out: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    engine: Literal["local", "dask"] = "local",
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    trials: int | None = None,
    retry: bool = False,
    report: bool = True,
) -> int:
    """Run a study: progress, a run folder per mission, an answer and a report.

    The same command resumes an interrupted study. After a change of its file, only missions that
    are new are run.

    Args:
        file: a study's file, or the folder of a study that was run before.
        jobs: processes on this machine; by default one per core.
        out: the study's folder; by default runs/study-NAME.
        engine: local, or dask for a cluster (extra "cluster").
        scheduler: the Dask scheduler's address, for example tcp://10.0.0.1:8786.
        trials: overrides the file's number of trials.
        retry: also run missions again that failed before.
        report: print the answer and write report.html, report.md, figures and data.
    """
    from swarmscout.core.errors import StudyError
    from swarmscout.studies.design import design_of
    from swarmscout.studies.study import Study

    if engine == "dask" and scheduler is None:
        raise StudyError("--engine dask needs --scheduler ADDRESS")
    if engine == "local" and scheduler is not None:
        raise StudyError("--scheduler is for --engine dask")
    if trials is not None and trials < 1:
        raise StudyError(f"--trials {trials}: at least 1 is needed")
    chosen = Study.load(file, out, trials=trials)
    if chosen.todo(retry=retry):
        design = design_of(chosen)
        word = "warning" if design.is_weak else "design"
        print(_wrapped(f"{word}: {design.describe()}"), flush=True)
    failures = run_and_show(chosen, jobs=jobs, scheduler=scheduler, retry=retry)
    silent = ""
    if report:
        from swarmscout.studies.report import write_report

        written = write_report(chosen)
        silent = written.silent_models
        for line in written.summary:
            print(_wrapped(line))
    print(f"study: {chosen.folder.path}")
    if report:
        print(f"report: {written.page}")
    return 2 if failures else 3 if silent else 0


def run_and_show(
    study: Study, *, jobs: int | None = None, scheduler: str | None = None, retry: bool = False
) -> int:
    """Run what is left of a study with progress; returns the number of its failed missions."""
    from swarmscout.cli.compiling import say_if_compiling
    from swarmscout.cli.interrupts import Interrupted
    from swarmscout.cli.study_progress import StudyProgress
    from swarmscout.core.cores import usable_cores
    from swarmscout.core.errors import StudyError
    from swarmscout.studies.engines import DaskEngine, LocalEngine
    from swarmscout.studies.progress import RunningTotals
    from swarmscout.studies.scheduler import run_study

    engine: Any
    if scheduler is None:
        engine = LocalEngine(usable_cores() if jobs is None else jobs)
    else:
        engine = DaskEngine(scheduler)
    left = len(study.todo(retry=retry))
    planned = len({mission.name for mission in study.missions})
    if left:
        done = f", {planned - left} of them done before" if left < planned else ""
        print(f"{study.declared.name}: {planned} missions{done}", flush=True)
        say_if_compiling()
    else:
        print(f"{study.declared.name}: all {planned} missions were run before", flush=True)
    totals = RunningTotals(study, left)
    baseline = str(study.declared.compare.baseline)
    try:
        with _warnings_as_notes(), StudyProgress(totals, study.compared.name, baseline) as progress:
            run_study(study, engine, retry=retry, listener=progress.count)
    except Interrupted as stopped:
        raise Interrupted(stopped.signal, f"{stopped}: {_kept(study, planned)}") from None
    except StudyError as error:
        if not totals.ended:
            raise
        raise StudyError(f"{error}: {_kept(study, planned)}") from None
    finally:
        if scheduler is not None:
            engine.close()
    return _list_failures(study)


@contextmanager
def _warnings_as_notes() -> Iterator[None]:
    """Print warnings of this package as one line each, without a place in its code."""
    import sys
    import warnings

    shown = warnings.showwarning

    def note(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if category is UserWarning:
            print(f"note: {message}", file=sys.stderr, flush=True)
        else:
            shown(message, category, *place, **more)

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = note
        yield


def _kept(study: Study, planned: int) -> str:
    done = planned - len(study.todo(retry=True))
    return f"{done} of {planned} missions are finished, the same command goes on"


def _list_failures(study: Study) -> int:
    """List failed missions, those with the same error together."""
    import sys

    failures = study.failures()
    by_error: dict[str, list[str]] = {}
    for failure in failures:
        by_error.setdefault(failure.error, []).append(failure.mission)
    for error, names in list(by_error.items())[:10]:
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        print(f"failed: {names[0]}{more}: {error}", file=sys.stderr)
    if failures:
        count = f"{len(failures)} mission{'s' if len(failures) > 1 else ''}"
        print(
            f"{count} failed (--retry runs them again; tracebacks are in {study.folder.failures})",
            file=sys.stderr,
        )
    return len(failures)


def _wrapped(line: str) -> str:
    """A line folded between words to the terminal's width, if there is a terminal."""
    import textwrap
    from shutil import get_terminal_size

    width = get_terminal_size((10_000, 24)).columns
    return textwrap.fill(line, max(20, width), subsequent_indent="  ")
