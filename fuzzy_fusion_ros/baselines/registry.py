"""Every baseline by name: how to make it, and what a fit may move."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from fuzzy_fusion_ros.baselines.complementary import complementary
from fuzzy_fusion_ros.baselines.constant_weight import constant_weight
from fuzzy_fusion_ros.baselines.kalman import kalman
from fuzzy_fusion_ros.baselines.parameters import BaselineParameters, ConstantWeightParameters
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.parameters.group import descriptors, flatten

REACH = 1000.0
"""Largest factor by which a fit may move a parameter from its start, either way."""


class Knob(NamedTuple):
    """A parameter that a fit may move.

    Attributes:
        name: Its dotted name in :class:`BaselineParameters`.
        low: Smallest value to try.
        high: Largest value to try.
        logarithmic: Whether the scale is logarithmic.
    """

    name: str
    low: float
    high: float
    logarithmic: bool


class Baseline(NamedTuple):
    """A filter that a user would pick instead.

    Attributes:
        method: Makes the method.
        moved: Dotted names of the numbers that a fit moves. Only ratios of noises matter, so one
            of them is fixed.
        switches: Dotted names of the booleans of which a fit tries both values.
    """

    method: Callable[[BaselineParameters], Method]
    moved: tuple[str, ...] = ()
    switches: tuple[str, ...] = ()

    def knobs(self, parameters: BaselineParameters) -> tuple[Knob, ...]:
        """Return what a fit may move, with limits around the given values.

        Args:
            parameters: Where the fit starts, as :func:`baselines_for` derives it.
        """
        values = flatten(parameters)
        return tuple(_knob(name, float(values[name])) for name in self.moved)


BASELINES: Mapping[str, Baseline] = MappingProxyType(
    {
        "s1": Baseline(lambda _: constant_weight(ConstantWeightParameters(1.0))),
        "s2": Baseline(lambda _: constant_weight(ConstantWeightParameters(0.0))),
        "average": Baseline(lambda _: constant_weight(ConstantWeightParameters(0.5))),
        "constant_weight": Baseline(
            lambda parameters: constant_weight(parameters.constant_weight),
            ("constant_weight.weight",),
        ),
        "complementary": Baseline(
            lambda parameters: complementary(parameters.complementary),
            ("complementary.time_constant",),
            ("complementary.s2_lags",),
        ),
        "complementary_lowpass": Baseline(
            lambda parameters: complementary(parameters.complementary_lowpass),
            ("complementary_lowpass.time_constant", "complementary_lowpass.lowpass_time_constant"),
            ("complementary_lowpass.s2_lags",),
        ),
        "kalman": Baseline(
            lambda parameters: kalman(parameters.kalman),
            ("kalman.s1_noise", "kalman.s2_noise"),
        ),
        "kalman_bias": Baseline(
            lambda parameters: kalman(parameters.kalman_bias),
            ("kalman_bias.s1_noise", "kalman_bias.s2_noise", "kalman_bias.bias_noise"),
        ),
    }
)
"""In the order in which tables show them."""


def methods(parameters: BaselineParameters) -> dict[str, Method]:
    """Return every baseline's method by its name."""
    return {name: baseline.method(parameters) for name, baseline in BASELINES.items()}


def _knob(name: str, value: float) -> Knob:
    if name.endswith(".weight"):
        return Knob(name, 0.0, 1.0, logarithmic=False)
    limits = _LIMITS[name]
    low = max(value / REACH, limits.low)
    return Knob(name, low, min(value * REACH, limits.high), logarithmic=True)


_LIMITS = {name: descriptor for name, descriptor, _ in descriptors(BaselineParameters)}
