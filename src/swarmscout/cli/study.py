"""``swarmscout study``: run a study, and go on with one that was interrupted."""

from __future__ import annotations

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
    """Run a study: progress, a run folder per mission, a report.

    An interrupted study goes on where it was when the same command is given again; what a changed
    file adds is run, and what it shares with the earlier one is not run twice.

    Args:
        file: a study's file, or the folder of a study that was begun.
        jobs: processes on this machine; by default as many as it has cores.
        out: the study's folder; by default runs/study-NAME.
        engine: local, or dask for a cluster (extra "cluster").
        scheduler: the Dask scheduler's address, for example tcp://10.0.0.1:8786.
        trials: instead of the file's number of trials.
        retry: also try the missions again that failed before.
        report: write report.html, report.md, figures and data when all is done.
    """
    from swarmscout.core.errors import StudyError
    from swarmscout.studies.study import Study

    if engine == "dask" and scheduler is None:
        raise StudyError("--engine dask needs --scheduler ADDRESS")
    if engine == "local" and scheduler is not None:
        raise StudyError("--scheduler is for --engine dask")
    if trials is not None and trials < 1:
        raise StudyError(f"--trials {trials}: at least 1 is needed")
    chosen = Study.load(file, out, trials=trials)
    failures = run_and_show(chosen, jobs=jobs, scheduler=scheduler, retry=retry)
    print(f"study: {chosen.folder.path}")
    if report:
        from swarmscout.studies.report import write_report

        print(f"report: {write_report(chosen)}")
    return 2 if failures else 0


def run_and_show(
    study: Study, *, jobs: int | None = None, scheduler: str | None = None, retry: bool = False
) -> int:
    """Run what is left of a study and say how it goes; returns how many of its missions failed."""
    from swarmscout.cli.compiling import say_if_compiling
    from swarmscout.cli.interrupts import Interrupted
    from swarmscout.cli.study_progress import StudyProgress
    from swarmscout.core.errors import StudyError
    from swarmscout.studies.engines import DaskEngine, LocalEngine
    from swarmscout.studies.progress import SoFar
    from swarmscout.studies.scheduler import run_study

    engine: Any
    if scheduler is None:
        engine = LocalEngine(_cores() if jobs is None else jobs)
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
    known = SoFar(study, left)
    baseline = str(study.declared.compare.baseline)
    try:
        with StudyProgress(known, study.compared.name, baseline) as progress:
            run_study(study, engine, retry=retry, listener=progress.count)
    except Interrupted as stopped:
        raise Interrupted(stopped.signal, f"{stopped}: {_kept(study, planned)}") from None
    except StudyError as error:
        if not known.ended:
            raise
        raise StudyError(f"{error}: {_kept(study, planned)}") from None
    finally:
        if scheduler is not None:
            engine.close()
    return _list_failures(study)


def _kept(study: Study, planned: int) -> str:
    done = planned - len(study.todo(retry=True))
    return f"{done} of {planned} missions are finished, the same command goes on"


def _list_failures(study: Study) -> int:
    """Say which missions failed, the same errors together."""
    import sys

    failures = study.failures()
    by_error: dict[str, list[str]] = {}
    for failure in failures:
        by_error.setdefault(failure.error, []).append(failure.mission)
    for error, names in list(by_error.items())[:10]:
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        print(f"failed: {names[0]}{more}: {error}", file=sys.stderr)
    if failures:
        where = study.folder.failures
        print(
            f"{len(failures)} missions failed (--retry tries them again; {where} says where)",
            file=sys.stderr,
        )
    return len(failures)


def _cores() -> int:
    import os

    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
