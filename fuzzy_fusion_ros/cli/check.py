# SPDX-License-Identifier: Apache-2.0
"""Characterises the two sensors of a recording, before any filter, and reports what is wrong.

It checks rates, gaps, stamps against arrival times, clock offsets, lag, noise, sign, scale (degrees
for radians, g for m/s^2, km/h for m/s, Pa for hPa), a rate in place of a value, angles that wrap,
spikes and stuck values, and names the parameter or option that fixes each problem. The exit status
is 1 if a problem is found.

Without topics it lists the numbers in the bag that move together, with their lag and scale,
whatever their topics and types; /s1 and /s2 are then checked only if the bag has them.

Several bags give one table and one JSON document; only the document lists the numbers that move
together. A bag that cannot be checked gets a row with the reason, and the exit status is 1.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fuzzy_fusion_ros.cli import fleet, options
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say, show
from fuzzy_fusion_ros.jobs.fleet import Failure
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.text.table import bag_table

if TYPE_CHECKING:
    from fuzzy_fusion_ros.jobs.check import CheckResult


@command("check")
def main(arguments: Sequence[str] | None = None) -> int:
    """Check one or several bags; return whether no problem was found."""
    given = command_line().parse_args(arguments)
    topics, window = options.topics_of(given), options.window_of(given)
    options.require_results(given, *given.bag, given.params)
    from fuzzy_fusion_ros.jobs.check import check  # after parsing: takes time to import

    bags = fleet.bags_of(given)
    task = functools.partial(
        check,
        parameters=fleet.absolute(given.params, given),
        topics=topics if topics != Topics() or given.s1 or given.s2 else None,
        **window,
        search=len(bags) == 1 or bool(given.json),  # a table does not show what it finds
        progress=fleet.progress_of(given),
    )
    found = dict(zip(bags, fleet.run(task, {each: each for each in bags}, given), strict=True))
    documents = {}
    fine = True
    for bag, each in found.items():
        if isinstance(each, Failure):
            documents[bag] = {"error": each.reason}
            fine = False
            continue
        documents[bag] = each.as_json()
        fine &= each.is_fine
        for note in each.notes:
            say("check", f"{bag}: {note}")
    show(_text(found), on_stderr=given.json == "-")
    if given.json:
        only = next(iter(documents.values()))
        options.write_json(only if len(documents) == 1 else documents, given.json)
    return DONE if fine else FAILED


def _text(found: Mapping[str, CheckResult | Failure]) -> str:
    """Return what was found: of one bag all of it, of several a row each."""
    from fuzzy_fusion_ros.checking.finding import Level  # after parsing: takes time to import

    rows: list[tuple[str, ...]] = [("bag", "problems", "")]
    for bag, each in found.items():
        if isinstance(each, Failure):
            rows.append(fleet.failed_row(bag, each, len(rows[0])))
            continue
        if len(found) == 1:
            return each.report()
        findings = () if each.check is None else each.check.findings
        wrong = [str(one) for one in findings if one.level is not Level.INFO]
        words = "; ".join(wrong) or ("" if each.check else "not checked: it has no /s1 and /s2")
        rows.append((bag, str(len(wrong)), words))
    return bag_table(rows)


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("check", __doc__)
    fleet.add_bags(parser)
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    options.add_json(parser)
    return parser
