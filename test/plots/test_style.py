# SPDX-License-Identifier: Apache-2.0
"""How figures look: legible colours, reproducible files, nothing left behind."""

from __future__ import annotations

import itertools
from pathlib import Path

import matplotlib
import numpy as np
import pytest

from fuzzy_fusion_ros.baselines import BASELINES
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.plots.names import COLOURS, NAMES
from fuzzy_fusion_ros.plots.style import WIDTH_PX, new_figure, save, styled

# Linear RGB to what people with each of the three kinds of colour blindness see: Viénot, Brettel
# and Mollon, "Digital video colourmaps for checking the legibility of displays by dichromats"
# (1999), and for tritanopia the matrices of Machado et al. (2009) at full severity.
BLINDNESS = {
    "none": np.eye(3),
    "protanopia": np.array(
        [[0.11238, 0.88762, 0.0], [0.11238, 0.88762, 0.0], [0.00401, -0.00401, 1.0]]
    ),
    "deuteranopia": np.array(
        [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}
TOGETHER = ("truth", "s1", "s2", "estimate", "complementary", "kalman")


def seen(colour: str, blindness: np.ndarray) -> np.ndarray:
    """Return a colour in CIE L*a*b* as it is seen."""
    srgb = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(blindness @ linear, 0.0, 1.0)
    xyz = (
        np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
        @ linear
        / np.array([0.9505, 1.0, 1.089])
    )
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("kind", BLINDNESS)
@pytest.mark.parametrize(("one", "other"), list(itertools.combinations(TOGETHER, 2)))
def test_what_is_drawn_together_can_be_told_apart(one: str, other: str, kind: str) -> None:
    matrix = BLINDNESS[kind]
    distance = np.linalg.norm(seen(COLOURS[one], matrix) - seen(COLOURS[other], matrix))
    assert distance > 12.0  # a just noticeable difference is about 2.3


def test_every_method_has_a_colour_and_a_name() -> None:
    assert set(COLOURS) == set(NAMES)
    methods = {"ideal", "s1", "s2", "average", "no_drift", "aggregator", "complete"}
    methods |= {"complementary", "kalman", "truth", "estimate", *BASELINES}
    assert methods <= set(COLOURS)
    assert COLOURS["complete"] == COLOURS["estimate"]


def test_the_style_is_left_as_it_was() -> None:
    before = dict(matplotlib.rcParams)
    with styled():
        assert dict(matplotlib.rcParams) != before
    assert dict(matplotlib.rcParams) == before


def test_a_figure_is_as_wide_as_a_readme() -> None:
    figure, axes = new_figure(2, 3, height_px=400)
    assert figure.get_size_inches() * figure.dpi == pytest.approx([WIDTH_PX, 400])
    assert len(axes) == 6


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_the_same_figure_gives_the_same_bytes(tmp_path: Path, suffix: str) -> None:
    for name in ("one", "two"):
        with styled():
            figure, (axes,) = new_figure()
            axes.plot([0.0, 1.0], [0.0, 1.0], color=COLOURS["estimate"], label="estimate")
            axes.legend()
            save(figure, tmp_path / "new" / f"{name}.{suffix}")
    one, two = (tmp_path / "new" / f"{name}.{suffix}" for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()


def test_a_format_must_be_known(tmp_path: Path) -> None:
    figure, _ = new_figure()
    with pytest.raises(FusionError, match=r"an unknown format: use one of .*\.png"):
        save(figure, tmp_path / "plot.xyz")


def test_a_file_must_be_writable(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    figure, _ = new_figure()
    with pytest.raises(FusionError, match="cannot be written"):
        save(figure, tmp_path / "file" / "plot.png")
