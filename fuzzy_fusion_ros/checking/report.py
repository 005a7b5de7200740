# SPDX-License-Identifier: Apache-2.0
"""Checks and surveys as text and as JSON."""

from __future__ import annotations

import math
import re
import shlex
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fuzzy_fusion_ros.batch.lag import GUESS_BELOW
from fuzzy_fusion_ros.checking.check import Character, Check
from fuzzy_fusion_ros.checking.finding import Finding
from fuzzy_fusion_ros.checking.presets import Advice
from fuzzy_fusion_ros.checking.relation import Kind, Relation
from fuzzy_fusion_ros.checking.survey import Field, Together
from fuzzy_fusion_ros.online.clocks import apart, duration
from fuzzy_fusion_ros.parameters.arguments import called
from fuzzy_fusion_ros.text.table import WIDTH, text_table

MOST_PAIRS = 30
"""Pairs of a survey that are printed."""

SHOWN = 5e-4
"""Seconds by which stamps must differ to be worth a line."""

_ROWS: dict[str, Callable[[Character], str]] = {
    "samples": lambda each: str(each.samples),
    "usable": lambda each: str(each.usable),
    "rate": lambda each: f"{1.0 / each.interval:.4g} Hz",
    "longest gap": lambda each: duration(each.gap),
    "delivery, median": lambda each: _signed_seconds(each.delivery),
    "delivery, 99 %": lambda each: _signed_seconds(each.latest),
    "least value": lambda each: f"{each.low:.4g}",
    "largest value": lambda each: f"{each.high:.4g}",
    "white noise": lambda each: f"{each.noise:.2g}",
    "repeated values": lambda each: f"{100.0 * each.repeated:.1f} %",
    "spikes": lambda each: f"{100.0 * each.spikes:.1f} %",
}


def check_text(check: Check) -> str:
    """Return what the sensors are like, and what is wrong with them."""
    blocks = [_characters(check), _pair(check), _findings(check.findings)]
    return "\n\n".join(block for block in blocks if block)


def check_json(check: Check) -> dict[str, Any]:
    """Return a check as ``check --json`` writes it; what is unknown is null."""
    return {
        "sensors": {name: _finite(each._asdict()) for name, each in check.characters.items()},
        "s2_behind_s": check.behind if math.isfinite(check.behind) else None,
        "relation": None if check.relation is None else _relation(check.relation),
        "findings": [each.as_json() for each in check.findings],
    }


def survey_text(found: Sequence[Together]) -> str:
    """Return which fields move together."""
    if not found:
        return "no two numbers of different topics move together"
    rows = [["correlation", "lag", "scale", "s1, s2"]]
    for each in found[:MOST_PAIRS]:
        relation = each.relation
        fields = f"{_name(each.s1)}, {_name(each.s2)}"
        if relation.kind is not Kind.VALUE:
            fields += f" ({relation.kind.value})"
        rows.append(
            [
                f"{relation.correlation:.3f}",
                _signed_seconds(relation.lag),
                f"{relation.sign * relation.middle_scale:.3g}",
                fields,
            ]
        )
    more = len(found) - MOST_PAIRS
    rest = [f"and {more} more pairs: --json lists all"] if more > 0 else []
    return "\n".join(["numbers that move together", text_table(rows, align="rrrl"), *rest])


def survey_json(found: Sequence[Together]) -> list[dict[str, Any]]:
    """Return a survey as ``check --json`` writes it."""
    return [
        {
            "s1": {"topic": each.s1.topic, "field": each.s1.path},
            "s2": {"topic": each.s2.topic, "field": each.s2.path},
            **_relation(each.relation),
        }
        for each in found
    ]


def advice_text(advice: Sequence[Advice], bag: str, presets: Path) -> str:
    """Return which presets suit a recording, with the commands that tune them.

    Where a preset needs additions, a copy gets them first.

    Args:
        advice: The presets.
        bag: The path of the recording.
        presets: The folder that they are in.
    """
    lines = ["presets that suit, and how to tune them:"]
    for each in advice:
        name = f"{each.job.preset}.yaml"
        with_more = f" with {' and '.join(each.additions)}" if each.additions else ""
        lines.append(f"{name}{with_more}: {_why(each)}")
        file = str(presets / name)
        if each.additions:
            added = shlex.join(["printf", r"    %s\n", *each.additions])
            file = f"my_{name}"
            command = f"({shlex.join(['cat', str(presets / name)])}\n {added}) > {file}"
            lines.append(textwrap.indent(command, "  "))
        options = f"{shlex.join(['--params', file])} {_options(each)}"
        command = f"{called('tune')} {shlex.quote(bag)} \\\n{_wrapped_options(options)}"
        lines.append(textwrap.indent(command, "  "))
    return "\n".join(lines)


def advice_json(advice: Advice) -> dict[str, Any]:
    """Return a preset that suits a recording as ``check --json`` writes it."""
    return {
        "preset": f"{advice.job.preset}.yaml",
        "set": advice.additions,
        "options": _options(advice),
        "correlation": None if advice.relation is None else advice.relation.correlation,
    }


def _options(advice: Advice) -> str:
    """Return the options of ``check``, ``tune``, ``score`` and ``replay`` for its sensors."""
    s1, s2 = advice.s1, advice.s2
    topics = ["--s1", s1.topic, "--s2", s2.topic]
    return shlex.join([*topics, "--field", f"s1={s1.path}", "--field", f"s2={s2.path}"])


def _why(advice: Advice) -> str:
    if advice.relation is None:
        return "gyro and accelerometer of one message"
    relation = advice.relation
    return f"correlation {relation.correlation:.3f}, lag {_signed_seconds(relation.lag)}"


def _wrapped_options(options: str) -> str:
    """Return options on lines of a terminal, broken before options only."""
    lines = [""]
    for option in re.split(r" (?=--)", options):
        if lines[-1] and len(lines[-1]) + len(option) > WIDTH - 8:
            lines[-1] += " \\"
            lines.append("")
        lines[-1] = f"{lines[-1]} {option}".lstrip()
    return "\n".join(lines)


def _characters(check: Check) -> str:
    found = list(check.characters.values())
    if not found:
        return ""
    head = ["", *(each.name for each in found)]
    table = text_table([head, *([name, *map(row, found)] for name, row in _ROWS.items())])
    return "\n".join([*(f"{each.name} is {each.source}" for each in found), table])


def _pair(check: Check) -> str:
    lines = []
    if math.isfinite(check.behind) and abs(check.behind) >= SHOWN:
        lines.append(f"when both arrive together, {apart(check.behind)}")
    if check.relation is not None:
        relation = check.relation
        way = "lags" if relation.lag >= 0.0 else "leads"
        guess = "" if abs(relation.correlation) >= GUESS_BELOW else " (a guess)"
        lines.append(
            f"s2 {way} s1 by {duration(abs(relation.lag))}{guess}; correlation "
            f"{relation.correlation:.3f}, scale {relation.sign * relation.middle_scale:.3g}"
        )
    return "\n".join(lines)


def _findings(findings: Sequence[Finding]) -> str:
    if not findings:
        return "no problems found"
    return "\n".join(
        textwrap.fill(
            f"{each.level.name:7} {each}",
            WIDTH,
            subsequent_indent=" " * 8,
            break_long_words=False,
            break_on_hyphens=False,
        )
        for each in findings
    )


def _relation(relation: Relation) -> dict[str, Any]:
    return {
        "kind": relation.kind.name.lower(),
        "sign": relation.sign,
        "lag_s": relation.lag,
        "scale": relation.middle_scale,
        "scale_from": relation.scale[0],
        "scale_to": relation.scale[1],
        "correlation": relation.correlation,
        "chance": relation.chance,
    }


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: value if not isinstance(value, float) or math.isfinite(value) else None
        for name, value in values.items()
    }


def _signed_seconds(seconds: float) -> str:
    return f"-{duration(-seconds)}" if seconds <= -5e-5 else duration(abs(seconds))


def _name(field: Field) -> str:
    return f"{field.topic} {field.path}"
