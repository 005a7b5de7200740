# SPDX-License-Identifier: Apache-2.0
"""Every parameter of the fusion: one definition for node, YAML, command line, docs and Python.

Defaults of the aggregator, the predictor and the gate are fitted to the benchmark of the docs
(a pendulum angle in rad); ``tune`` fits them to a recording.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fuzzy_fusion_ros.parameters.errors import CombinationError, ParameterError
from fuzzy_fusion_ros.parameters.group import (
    Group,
    Value,
    descriptors,
    flatten,
    group,
    integer,
    names,
    real,
    replace,
    switch,
    text,
)

CHANNEL = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
"""A channel's name: it is part of the names of parameters and topics."""


BUILTIN = {"use_sim_time", "start_type_description_service", "qos_overrides"}
"""Parameters that every ROS node has; below the last, any number of them."""


@dataclass(frozen=True)
class BreakPoints(Group):
    """Fig. 4: where *large* starts to rise from 0, and where it reaches 1."""

    small: float = real(0.0, "at and below this the input is entirely small")
    large: float = real(1.0, "at and above this the input is entirely large")

    def check_together(self) -> None:
        """Check that the ramp rises.

        Raises:
            CombinationError: ``small`` is not below ``large``.
        """
        if not self.small < self.large:
            raise CombinationError(
                "small", f"got {self.small!r}, expected less than large {self.large!r}"
            )


@dataclass(frozen=True)
class Weights(Group):
    """Table 1, W1: the weight of S1 that each rule concludes."""

    very_small: float = real(0.0, "W1 when the difference is large and the rate small", high=1.0)
    small: float = real(0.016, "W1 when difference and rate are small", high=1.0)
    large: float = real(0.12, "W1 when the difference is small and the rate large", high=1.0)
    very_large: float = real(0.42, "W1 when difference and rate are large", high=1.0)

    def order_problem(self) -> str:
        """Say if the levels are not in the order of their names, ``""`` if they are.

        They are accepted all the same, but the rules then do not mean what Table 1 says.
        """
        levels = (self.very_small, self.small, self.large, self.very_large)
        if list(levels) == sorted(levels):
            return ""
        got = ", ".join(f"{each:g}" for each in levels)
        return (
            "aggregator.weight.very_small, .small, .large, .very_large are expected to rise in "
            f"this order, got {got}: the reasons given for a weight will mislead; sort them, or "
            "run tune again"
        )


@dataclass(frozen=True)
class Drifts(Group):
    """Table 1, drift: what is added in the direction of the signal's motion."""

    small: float = real(0.0, "drift in all cases but that of drift.large", unit="signal")
    large: float = real(
        0.126, "drift when the difference is small and the rate large", unit="signal"
    )


@dataclass(frozen=True)
class AggregatorParameters(Group):
    """The fuzzy aggregator."""

    difference: BreakPoints = group(BreakPoints(0.07, 0.6))
    rate: BreakPoints = group(BreakPoints(0.01, 1.75))
    rate_time_constant: float = real(
        0.025,
        "time constant of the low-pass on dS2/dt; 0: the plain difference quotient",
        unit="s",
        high=1e6,
    )
    weight: Weights = group(Weights())
    drift: Drifts = group(Drifts())


@dataclass(frozen=True)
class PredictorParameters(Group):
    """The fuzzy predictor."""

    enabled: bool = switch(False, "run the fuzzy predictor")
    samples: int = integer(20, "number n of previous estimates kept", low=3, high=200)
    rules: int = integer(5, "number M of rules", low=2, high=50)
    slope: float = real(0.9, "slope of the steepest initial rule", unit="signal/s", low=1e-9)
    lead: float = real(2.3, "steps that the initial rules look ahead", unit="steps", high=100.0)
    learning_rate: float = real(0.005, "step size of the gradient descent", high=1.0)
    error_threshold: float = real(1e-3, "training stops below this error", unit="signal")
    max_iterations: int = integer(1, "maximum training steps per sample", low=0, high=1000)


@dataclass(frozen=True)
class GateParameters(Group):
    """The validity gate."""

    tolerance: float = real(
        0.04,
        "largest distance between prediction and aggregate at which they are averaged",
        unit="signal",
    )


@dataclass(frozen=True)
class SensorParameters(Group):
    """One input: its message type, the field that holds the scalar, and when it counts as lost."""

    type: str = text("geometry_msgs/msg/PointStamped", "message type, as package/msg/Type")
    field: str = text(
        "",
        "path of the number in the message, or a function of paths such as yaw(orientation); "
        "empty: the default of the type",
    )
    scale: float = real(
        1.0,
        "factor on the field: the sensor's value is scale * field + offset; not 0",
        low=-1e12,
        high=1e12,
        fixed=True,
    )
    offset: float = real(
        0.0, "offset added to the scaled field", unit="signal", low=-1e12, high=1e12, fixed=True
    )
    timeout: float = real(
        0.0,
        "after this long without a sample the sensor counts as lost and its history restarts; 0: "
        "automatic, five of its intervals, but at least 1 s for S1 and 5 s for S2",
        unit="s",
    )

    def check_together(self) -> None:
        """Check that the scale can be inverted.

        Raises:
            ParameterError: It is 0.
        """
        if self.scale == 0.0:
            raise ParameterError("scale", "got 0.0, expected any other number")


@dataclass(frozen=True)
class FastSensorParameters(SensorParameters):
    """S1, with its conditioning: our extension, off by default."""

    kind: str = text(
        "value",
        "value: S1 measures the same as S2; rate: it measures the derivative and is integrated",
        choices=("value", "rate"),
    )
    spike_threshold: float = real(
        0.0, "a step of S1 beyond this is rejected as a spike; 0: off", unit="signal"
    )
    lowpass_time_constant: float = real(
        0.0, "time constant of the low-pass on S1; 0: off", unit="s", high=1e6
    )
    noise: float = real(
        0.0,
        "noise of S1 that reaches the estimate, a part of its standard deviation",
        unit="signal",
    )
    bias_time_constant: float = real(
        0.0,
        "time constant for learning S1's bias from S2, through S2's lag (the observer); 0: off, "
        "the paper's blend",
        unit="s",
    )
    bias_prior: float = real(
        0.0, "standard deviation of S1's bias before the first S2; 0: unknown", unit="signal"
    )
    drift_time_constant: float = real(
        0.0, "time constant for learning the slope of S1's bias; 0: no slope", unit="s"
    )
    drift_prior: float = real(
        0.0,
        "standard deviation of the slope of S1's bias before the first S2; needs s2.noise > 0 and "
        "s1.drift_time_constant > 0; 0: the slope starts from 0",
        unit="signal/s",
    )

    DERIVED = ("is_rate",)

    @property
    def is_rate(self) -> bool:
        """Whether it is integrated, and so has no value of its own after a silence."""
        return self.kind == "rate"


@dataclass(frozen=True)
class SlowSensorParameters(SensorParameters):
    """S2, with the model of it through which S1's bias is learnt."""

    noise: float = real(
        0.0,
        "standard deviation of S2's noise, the scale of all uncertainty; 0: unknown",
        unit="signal",
    )
    lag_time_constant: float = real(0.0, "time constant of S2's lag", unit="s", high=1e6)
    delay: float = real(0.0, "delay of S2", unit="s", high=1e6)
    outlier_threshold: float = real(
        0.0,
        "an innovation of S2 counts as at most this many of its standard deviations, unless "
        "several in a row agree; needs s1.bias_time_constant > 0; 0: off",
        high=1e6,
    )


@dataclass(frozen=True)
class SignalParameters(Group):
    """The quantity that both sensors measure."""

    unit: str = text("", "unit of the signal; empty: that of the message types, which must agree")
    period: float = real(
        0.0,
        "period of a signal that wraps: 6.283185307179586 for rad, 360 for degrees; 0: none",
        unit="signal",
        fixed=True,
    )


@dataclass(frozen=True)
class AdaptParameters(Group):
    """What the observer adapts while running: our extension, off by default."""

    lag_time_constant: float = real(
        0.0,
        "time constant, while the signal moves, of adapting S2's lag and delay by one factor; "
        "0: off",
        unit="s",
    )
    scale_time_constant: float = real(
        0.0,
        "time constant, while the signal moves, of adapting the scale of S1 to S2; 0: off",
        unit="s",
    )


@dataclass(frozen=True)
class EstimateParameters(Group):
    """The output message, a copy of S2's latest unless named, and its standard deviation."""

    type: str = text("", "message type of the estimate; empty: that of S2")
    field: str = text(
        "", "path of the number in the estimate; empty: that of S2, or the default of the type"
    )
    variance_field: str = text(
        "",
        "path of the estimate's variance in its message, such as variance or pose.covariance[35]; "
        "empty: a variance that belongs to the number is marked as unknown",
    )
    deviation_scale: float = real(1.0, "factor on the standard deviation, fitted by tune", high=1e6)


@dataclass(frozen=True)
class ChannelParameters(Group):
    """What is set for each scalar of a node: two sensors and the method."""

    s1: FastSensorParameters = group(FastSensorParameters())
    s2: SlowSensorParameters = group(SlowSensorParameters())
    signal: SignalParameters = group(SignalParameters())
    estimate: EstimateParameters = group(EstimateParameters())
    aggregator: AggregatorParameters = group(AggregatorParameters())
    predictor: PredictorParameters = group(PredictorParameters())
    gate: GateParameters = group(GateParameters())
    adapt: AdaptParameters = group(AdaptParameters())


@dataclass(frozen=True)
class Parameters(ChannelParameters):
    """All parameters of the fusion: of one channel, or of several.

    Channels have what is named here in common but for ``own``: values of single channels by
    dotted name, such as ``roll.s1.field``.
    """

    trigger: str = text(
        "s1",
        "s1: at every S1 sample, newest S2 held; pair: when S1 and S2 with equal stamps have "
        "arrived; timer: at rate",
        choices=("s1", "pair", "timer"),
    )
    rate: float = real(100.0, "rate of the timer trigger", unit="Hz", low=1e-3, high=1e4)
    future_tolerance: float = real(
        10.0, "samples stamped further ahead of the clock than this are dropped", unit="s"
    )
    qos: str = text(
        "sensor_data",
        "quality of service of both inputs: best effort or reliable delivery",
        choices=("sensor_data", "reliable"),
    )
    self_tuning: bool = switch(
        False,
        "measure the conditioning of S1, the model of S2 and the rules while running; their "
        "parameters are then ignored",
        fixed=True,
    )
    record: str = text("", "bag directory to record inputs and outputs to; empty: none")
    lifecycle: bool = switch(
        False,
        "run as a managed (lifecycle) node, silent until configured and activated",
        fixed=True,
    )
    channels: tuple[str, ...] = names(
        "names of several scalars in the same messages, such as roll and pitch; roll.s1.field is "
        "then a parameter of roll alone, and s1.field the default of all; empty: one scalar"
    )
    own: tuple[tuple[str, Value], ...] = ()

    def check_together(self) -> None:
        """Check the names of channels, and that each channel's parameters go together.

        Raises:
            ParameterError: A name cannot be used, or a channel's parameters are not allowed.
        """
        for name in self.channels:
            if not CHANNEL.fullmatch(name):
                raise ParameterError(
                    "channels",
                    f"got {name!r}, expected letters, digits and single underscores between them, "
                    "and a letter first",
                )
            if name in BUILTIN or name in {field.name for field in dataclasses.fields(self)}:
                raise ParameterError("channels", f"{name!r} is a parameter: use another name")
            if self.channels.count(name) > 1:
                raise ParameterError("channels", f"{name!r} is listed twice: use each name once")
        self.variants()

    def variants(self) -> dict[str, ChannelParameters]:
        """Return what counts for each channel: its own, and what is shared where it has none."""
        shared = _tree_of(self)
        found = {}
        for channel in self.channels:
            start = f"{channel}."
            own = {name[len(start) :]: v for name, v in self.own if name.startswith(start)}
            try:
                found[channel] = replace(shared, own)
            except ParameterError as error:
                raise error.under(channel) from None
        return found

    def gathered(self, changes: Mapping[str, object]) -> Mapping[str, object]:
        """Return changes with those of channels gathered in ``own``.

        Raises:
            ParameterError: A change of a channel is not allowed.
        """
        channels = changes.get("channels") or self.channels
        if not isinstance(channels, list | tuple) or not channels:
            return changes
        known = {name: each for name, each, _ in descriptors(ChannelParameters)}
        own, shared = dict(self.own), {}
        for name, value in changes.items():
            channel, _, below = name.partition(".")
            if channel not in channels:
                shared[name] = value
            elif below in known:
                own[name] = known[below].check(name, value)
            else:
                raise ParameterError(name, f"unknown; known below {channel}: {', '.join(known)}")
        return {**shared, "own": tuple(own.items())}

    def by_channel(self) -> dict[str, Parameters]:
        """Return the parameters of each channel as if it were alone; of one, under ``""``."""
        if not self.channels:
            return {"": self}
        alone = dataclasses.replace(self, channels=(), own=())
        return {
            name: dataclasses.replace(alone, **_groups_of(tree))
            for name, tree in self.variants().items()
        }

    def channel(self, name: str) -> Parameters:
        """Return the parameters of one channel as if it were alone.

        Args:
            name: The channel; ``""`` where there are no names.

        Raises:
            ParameterError: There is no such channel, or there are several and none is named.
        """
        found = self.by_channel()
        if name in found:
            return found[name]
        if not self.channels:
            raise ParameterError("channels", f"is empty, so there is no channel {name!r}")
        names = ", ".join(self.channels)
        raise ParameterError(
            "channels",
            f"there is no {name!r}, only {names}"
            if name
            else f"there are several channels ({names}): choose one with --channel",
        )

    def only(self, name: str) -> Parameters:
        """Return the parameters without those of other channels than this one.

        Args:
            name: The channel; ``""`` leaves all.

        Raises:
            ParameterError: There is no such channel.
        """
        if not name:
            return self
        alone = self.channel(name)
        return dataclasses.replace(self, channels=(name,), own=()).with_channel(name, alone)

    def with_channel(self, name: str, parameters: ChannelParameters) -> Parameters:
        """Return the parameters with one channel's replaced, those of the others as they are.

        Args:
            name: The channel; ``""`` where there are no names.
            parameters: What counts for it from now on.
        """
        before = flatten(_tree_of(self.channel(name)))
        prefix = f"{name}." if name else ""
        after = flatten(_tree_of(parameters))
        return replace(self, {prefix + each: v for each, v in after.items() if v != before[each]})


def _groups_of(parameters: ChannelParameters) -> dict[str, Any]:
    """Return the groups that each channel has, by name."""
    return {
        field.name: getattr(parameters, field.name)
        for field in dataclasses.fields(ChannelParameters)
    }


def _tree_of(parameters: ChannelParameters) -> ChannelParameters:
    """Return the parameters of one channel alone, without those that all share."""
    return ChannelParameters(**_groups_of(parameters))
