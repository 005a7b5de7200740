# SPDX-License-Identifier: Apache-2.0
"""The parameter file that ``tune`` writes: the fusion's parameters and the baselines'.

Nodes read the former, ``score`` reads both.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.parameters.file import (
    ParameterFileError,
    dumps,
    load,
    parameters_from,
    read_text,
)
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace

BASELINES = "baselines"
"""The entry of a parameter file that holds the parameters of the baselines."""

Source = Parameters | str | Path | None
"""Parameters as a caller may give them: as such, as a file, or not at all for the defaults."""


def fusion_parameters(source: Source) -> Parameters:
    """Return the fusion's parameters.

    Raises:
        ParameterError: The file cannot be used.
    """
    if isinstance(source, Parameters):
        return source
    return Parameters() if source is None else parameters_from(source)


def baseline_parameters(source: Source, channel: str = "") -> BaselineParameters | None:
    """Return the parameters of the baselines in a file, ``None`` if it lacks any of them.

    Args:
        source: The file.
        channel: The channel whose baselines are meant; ``""`` where there are no names.

    Raises:
        ParameterError: A value is out of range.
    """
    if source is None or isinstance(source, Parameters):
        return None
    try:
        values = load(source, _entry(channel))
    except ParameterFileError:
        return None
    known = flatten(BaselineParameters())
    own = {name: value for name, value in values.items() if name in known}
    return replace(BaselineParameters(), own) if own.keys() == known.keys() else None


def text(
    parameters: Parameters,
    baselines: Mapping[str, BaselineParameters],
    comments: Iterable[str] = (),
) -> str:
    """Return the text of a file that holds both, each as its own entry.

    Args:
        parameters: Of the fusion.
        baselines: Of the baselines, by channel.
        comments: Lines to put at the top.
    """
    others = [dumps(each, node_name=_entry(name)) for name, each in baselines.items()]
    return "".join([dumps(parameters, comments), *others])


def _entry(channel: str) -> str:
    """Return the name of the entry with the baselines of a channel."""
    return f"{BASELINES}_{channel}" if channel else BASELINES


def text_of(source: Source) -> str:
    """Return parameters as the text of a file: as it stands, if they are in one.

    Raises:
        ParameterError: The file cannot be read.
    """
    if isinstance(source, str | Path):
        return read_text(source)
    return dumps(fusion_parameters(source))
