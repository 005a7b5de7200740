"""The parameter file that ``tune`` writes: the fusion's parameters, and beside them the baselines'.

Nodes read the former, ``score`` reads both.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.parameters.file import ParameterFileError, dump, load, parameters_from
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


def baseline_parameters(source: Source) -> BaselineParameters | None:
    """Return the parameters of the baselines in a file, ``None`` if it has none.

    Raises:
        ParameterError: A value is out of range.
    """
    if source is None or isinstance(source, Parameters):
        return None
    try:
        values = load(source, BASELINES)
    except ParameterFileError:
        return None
    known = flatten(BaselineParameters())
    own = {name: value for name, value in values.items() if name in known}
    return replace(BaselineParameters(), own) if own else None


def write(
    path: str | Path,
    parameters: Parameters,
    baselines: BaselineParameters,
    comments: Iterable[str] = (),
) -> None:
    """Write both, each as an entry of its own.

    Args:
        path: The file, overwritten if it exists; its directory is created.
        parameters: Of the fusion.
        baselines: Of the baselines.
        comments: Lines to write at the top.

    Raises:
        ParameterError: The file cannot be written.
        OSError: The directory cannot be created.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        second = Path(folder, "baselines.yaml")
        dump(baselines, second, node_name=BASELINES)
        dump(parameters, target, comments)
        with target.open("a", encoding="utf-8") as file:
            file.write(second.read_text(encoding="utf-8"))
