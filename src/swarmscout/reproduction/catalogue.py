"""The paper's figures by name, and their pages."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from swarmscout.core.errors import StudyError, did_you_mean
from swarmscout.core.version import package_version
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.reproduction import comparing, missions, sensing
from swarmscout.reproduction.options import LLM_LIKE, Options
from swarmscout.reproduction.reasoning import reasoning
from swarmscout.studies.report import write_pages
from swarmscout.studies.report_elements import Block, Code, Heading, Text

__all__ = ["PAPER_FIGURES", "PaperFigure", "command_of", "figures_named", "reproduce"]


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper.

    Attributes:
        title: of its page.
        make: makes the content of its page.
    """

    title: str
    make: Callable[[Options], list[Block]]


PAPER_FIGURES: dict[str, PaperFigure] = {
    "sensor": PaperFigure("The ray sensor (Fig. 1a)", sensing.sensor),
    "gridmap": PaperFigure("The occupancy grid (Fig. 1b)", sensing.gridmap),
    "team-formation": PaperFigure("Self-organized teams (Fig. 2)", missions.team_formation),
    "baseline": PaperFigure("Exploration by the baseline (Fig. 3)", missions.baseline),
    "llm-vs-baseline": PaperFigure(
        "Explored area: LLM and baseline (Fig. 4)", comparing.llm_vs_baseline
    ),
    "reasoning": PaperFigure("One decision in full (Fig. 5)", reasoning),
    "target-stats": PaperFigure("Properties of chosen cells (Fig. 6)", comparing.target_stats),
    "scale-50": PaperFigure("50 robots (Fig. 7)", missions.scale_50),
    "scale-100": PaperFigure("100 robots (Fig. 8)", missions.scale_100),
}


def figures_named(name: str) -> list[str]:
    """One figure, or all of them for ``all``.

    Raises:
        StudyError: the figure does not exist.
    """
    if name == "all":
        return list(PAPER_FIGURES)
    if name not in PAPER_FIGURES:
        raise StudyError(
            f"the paper has no figure '{name}': {did_you_mean(name, [*PAPER_FIGURES, 'all'])}"
        )
    return [name]


def reproduce(
    names: Sequence[str], options: Options, on_page: Callable[[str, Path], None]
) -> list[tuple[str, list[Block]]]:
    """Reproduce figures, each on a page in a folder of its name.

    Args:
        names: of :data:`PAPER_FIGURES`.
        options: ``out`` is the folder of all figures.
        on_page: called with each figure's name and page once it is written.

    Returns:
        The content of the pages, by figure.

    Raises:
        SwarmscoutError: a mission cannot be run, or a page cannot be written.
    """
    pages = []
    for name in names:
        figure = PAPER_FIGURES[name]
        its = replace(options, out=options.out / name)
        its.out.mkdir(parents=True, exist_ok=True)
        blocks = figure.make(its)
        page = write_pages(
            its.out,
            figure.title,
            [Heading(figure.title, 1), *blocks, *_how(name, options)],
            name="page",
        )
        on_page(name, page)
        pages.append((name, blocks))
    return pages


def command_of(name: str, options: Options) -> str:
    """The command that makes a figure."""
    counts = " --quick" if options.quick else ""
    if options.caves is not None:
        counts += f" --caves {options.caves}"
    who = options.llm.get("llm.base_url", options.llm.get("llm.provider"))
    asked = f" --llm {who}" if who else ""
    if "llm.model" in options.llm:
        asked += f" --llm-model {options.llm['llm.model']}"
    rule = f" --destinations {options.selector}" if options.selector != LLM_LIKE else ""
    return f"swarmscout reproduce {name}{counts}{rule}{asked}"


def _how(name: str, options: Options) -> list[Block]:
    return [
        Heading("How it was made"),
        Code(command_of(name, options)),
        Text(
            f"swarmscout {package_version()}, rules version {RULES_VERSION}, Python "
            f"{platform.python_version()}. The paper: H. Kawashima et al., AROB-ISBC 2026."
        ),
    ]
