"""``swarmscout reproduce``: the paper's figures from our own runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

__all__ = ["reproduce"]


def reproduce(
    name: str = "all",
    /,
    *,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("runs/paper"),
    jobs: Annotated[int | None, Parameter(show_default=False)] = None,
    destinations: str = "llm-like",
    llm: str | None = None,
    llm_model: str | None = None,
    llm_cassette: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    llm_mode: Literal["auto", "record", "replay", "refresh"] | None = None,
    caves: Annotated[int | None, Parameter(show_default=False)] = None,
    quick: bool = False,
) -> int:
    """Reproduce a figure of the paper: a page with the paper's claim and our result beside it.

    Figures: sensor, gridmap, team-formation, baseline, llm-vs-baseline, reasoning, target-stats,
    scale-50, scale-100.

    Args:
        name: a figure, or all.
        out: folder of the pages, with a folder for each figure.
        jobs: processes for the studies; default: the number of cores.
        destinations: the selector in the place of the paper's language model; llm asks one.
        llm: the provider: openai, azure, embedded, or the address of a compatible server.
        llm_model: the model's name, or Azure's deployment.
        llm_cassette: a file that keeps requests and replies.
        llm_mode: how the cassette is used, as for explore.
        caves: use the first caves only, of the ten of the comparing figures; 1 is the paper's own
            design, for a language model that is slow or costs money.
        quick: small counts, to check that everything works; titles say so.
    """
    from swarmscout.cli.compiling import say_if_compiling
    from swarmscout.cli.llm_options import llm_overrides
    from swarmscout.cli.study import run_and_show
    from swarmscout.core.errors import StudyError
    from swarmscout.reproduction.catalogue import figures_named
    from swarmscout.reproduction.catalogue import reproduce as make
    from swarmscout.reproduction.options import Options
    from swarmscout.studies.study import Study

    names = figures_named(name)
    if caves is not None and caves < 1:
        raise StudyError(f"--caves {caves}: at least 1")
    keys = llm_overrides(llm, llm_model, llm_cassette and llm_cassette.resolve(), llm_mode)
    say_if_compiling()

    def run_study(study: Study) -> None:
        failed = run_and_show(study, jobs=jobs)
        if failed:
            raise StudyError(f"{failed} missions of '{study.declared.name}' failed")

    options = Options(
        out=out, run_study=run_study, quick=quick, caves=caves, selector=destinations, llm=keys
    )
    make(names, options, lambda figure, page: print(f"{figure}: {page}", flush=True))
    return 0
