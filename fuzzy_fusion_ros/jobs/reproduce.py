# SPDX-License-Identifier: Apache-2.0
"""Reproduces the paper: runs, tables, figures, claims."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from fuzzy_fusion_ros.jobs.outputs import require_writable
from fuzzy_fusion_ros.jobs.parameter_file import Source, fusion_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.paper.checks import CheckedClaim
from fuzzy_fusion_ros.paper.claims import claims
from fuzzy_fusion_ros.paper.methods import Contender, contenders, warm_up
from fuzzy_fusion_ros.paper.results import Results
from fuzzy_fusion_ros.paper.sweep import NOMINAL, Outcome, points_of, simulate_at, sweep
from fuzzy_fusion_ros.paper.tables import INSIDE, RESPONSES, SWEPT, table_of, write_csv
from fuzzy_fusion_ros.paper.targets import targets
from fuzzy_fusion_ros.plots.contact_sheet import contact_sheet
from fuzzy_fusion_ros.plots.paper_figures import draw
from fuzzy_fusion_ros.plots.style import save, styled


class Reproduction(NamedTuple):
    """The paper, reproduced.

    Attributes:
        outcomes: All runs, by point, seed and method.
        claims: The paper's claims about the figures asked for.
        targets: Our own targets for them.
    """

    outcomes: list[Outcome]
    claims: list[CheckedClaim]
    targets: list[CheckedClaim]


def reproduce(
    output: str | Path,
    *,
    figures: Sequence[int],
    seeds: Sequence[int],
    jobs: int,
    parameters: Source = None,
    progress: Progress = SILENT,
) -> Reproduction:
    """Run what the figures need, and write them as PNG and CSV, with a contact sheet.

    Args:
        output: Directory to write into.
        figures: Numbers of the paper's figures, rising.
        seeds: Two or more seeds; Figs 6-17 show the first.
        jobs: Number of threads; it changes no result.
        parameters: Of the fusion, the same at every point, or the YAML file with them; the
            defaults unless given.
        progress: Shows progress; none is shown unless given.

    Raises:
        FusionError: The parameters or the output cannot be used, or a file of the output is that
            of the parameters.
    """
    sheet = Path(output) / "contact_sheet.png"
    stems = {figure: sheet.with_name(f"fig{figure:02d}") for figure in figures}
    files = [stem.with_suffix(suffix) for stem in stems.values() for suffix in (".csv", ".png")]
    require_writable(sheet, *files, inputs=[parameters])
    methods = contenders(fusion_parameters(parameters).channel(""))
    for contender in progress.over(methods, "compile"):
        warm_up(contender)
    swept = dict.fromkeys(SWEPT[figure].swept for figure in figures if figure in SWEPT)
    points = points_of(swept)
    runs = sweep(methods, points, seeds, jobs)
    outcomes = list(progress.over(runs, "simulate", len(methods) * len(points) * len(seeds)))
    results = Results(outcomes)
    pictures = [
        _figure(figure, methods, seeds[0], results, stems[figure])
        for figure in progress.over(figures, "draw")
    ]
    with styled():
        save(contact_sheet(pictures), sheet)
    return Reproduction(outcomes, claims(results, figures), targets(results, figures))


def _figure(
    number: int, methods: Sequence[Contender], seed: int, results: Results, stem: Path
) -> Path:
    shown = {"ideal", RESPONSES.get(number), INSIDE.get(number)} if number not in SWEPT else set()
    runs = {each.name: simulate_at(each, NOMINAL, seed) for each in methods if each.name in shown}
    table = table_of(number, runs, results)
    write_csv(table, stem.with_suffix(".csv"))
    with styled():
        save(draw(number, table), stem.with_suffix(".png"))
    return stem.with_suffix(".png")
