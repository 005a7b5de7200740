# SPDX-License-Identifier: Apache-2.0
"""What our nodes have in common: parameters in one checked dataclass, and shutdown."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.exceptions import ParameterException
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node
from rclpy.parameter import Parameter

from fuzzy_fusion_ros.parameters.errors import CombinationError, FusionError, ParameterError
from fuzzy_fusion_ros.parameters.file import is_builtin, load, refuse
from fuzzy_fusion_ros.parameters.group import (
    Descriptor,
    Group,
    Value,
    described,
    flatten,
    replace,
    shaped,
)
from fuzzy_fusion_ros.ros.recorder import NoRecorder, Recorder

G = TypeVar("G", bound=Group)

Values = dict[str, Value | None]
"""Values of parameters by their dotted names, ``None`` for one that is deleted."""


class ConfiguredNode(Node, Generic[G]):
    """A node whose parameters are those of a group: described, checked, changed all or none.

    Attributes:
        parameters: The values in use.
        held: Values that were set one by one and are only allowed together with others that have
            not been set yet; they are not in use.
        recorder: What records; closed with the node.
        finished: Whether there is nothing left to do.
        failure: What makes it impossible to go on, if anything does.
        log: The node's logger.
        spinning: Whether an executor has begun to serve the node.
    """

    def __init__(
        self,
        name: str,
        defaults: G,
        *,
        fixed: bool = False,
        parameter_files: Sequence[str | Path] = (),
        **options: Any,
    ) -> None:
        """Declare every parameter of the group, then set up; a node that fails is closed again.

        Args:
            name: Name of the node.
            defaults: The group; overrides from the command line and files go on top.
            fixed: Whether all of them are read at start-up only.
            parameter_files: Files that ROS has been given for this node, to check.
            options: As :class:`rclpy.node.Node` takes them.

        Raises:
            ParameterError: An override is unknown, of the wrong type or out of range, or a file
                holds nothing for this node.
            FusionError: What :meth:`set_up` needs cannot be had.
        """
        try:
            super().__init__(name, **options)
        except ParameterException as error:  # of one that every node has
            with contextlib.suppress(AttributeError):  # it is half made
                Node.destroy_node(self)
            self.handle.destroy_when_not_in_use()
            raise ParameterError(_builtin_in(str(error)), str(error)) from None
        self.log: RcutilsLogger = Node.get_logger(self)
        self.recorder: Recorder = NoRecorder()
        self.spinning = False
        self.finished = False
        self.failure: FusionError | None = None
        self.held: Values = {}
        try:
            for path in parameter_files:
                load(path, self.get_fully_qualified_name())
            self.parameters = self._declared(defaults, fixed)
            self.set_up()
        except FusionError:
            self.destroy_node()
            raise
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._first = self.create_timer(1e-3, self.guarded(self._on_first), clock=steady)

    def _declared(self, defaults: G, fixed: bool) -> G:
        overrides: Mapping[str, Parameter] = self._parameter_overrides
        given = {name: each.value for name, each in overrides.items()}
        self._described = described(shaped(defaults, given))
        self._fixed = {name for name, each in self._described.items() if fixed or each.fixed}
        parameters = replace(defaults, self._own(overrides.values()))
        for name, value in flatten(parameters).items():
            descriptor = to_message(self._described[name], name in self._fixed)
            self.declare_parameter(name, value, descriptor, ignore_override=True)
        return parameters

    def set_up(self) -> None:
        """Create what the node is made of; ``parameters`` are there.

        Raises:
            FusionError: A parameter, a message type, a field or a bag cannot be used.
        """

    def on_spinning(self) -> None:
        """Do what has to wait until an executor serves the node; called once.

        Messages that come before that are served topic by topic, not in the order in which
        they came.
        """

    def _on_first(self) -> None:
        self._first.cancel()
        self.spinning = True
        self.on_spinning()
        for name in self._parameter_overrides:
            if not self.has_parameter(name):  # of a topic that is not there
                known = ", ".join(n for n in self._parameters if n.startswith("qos_overrides."))
                raise ParameterError(name, f"unknown; expected one of {known}")

    def fail(self, error: FusionError) -> None:
        """End the node because of an error."""
        self.failure = error
        self.finished = True

    def guarded(self, callback: Callable[..., None]) -> Callable[..., None]:
        """Return a callback whose :class:`FusionError` ends the node, not the executor."""

        @functools.wraps(callback)
        def guard(*arguments: Any) -> None:
            try:
                if not self.finished:
                    callback(*arguments)
            except FusionError as error:
                self.fail(error)

        return guard

    def on_parameters(self) -> None:
        """React to new values in ``parameters``; called after each successful set."""

    def destroy_node(self) -> None:
        """Finish the bag, then leave the graph."""
        self.recorder.close()
        for timer in self.timers:  # the executor may have queued one, and still calls it otherwise
            timer.cancel()
        Node.destroy_node(self)

    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]:
        """Set parameters one by one, as rclpy does."""
        return [self.set_parameters_atomically([each]) for each in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set parameters, all or none; a refusal names parameter, value and range.

        A single value that is only refused in combination with others is held until these are set
        as well, so that files load in any order. rclpy's own checks come after ours: its refusals
        leave out the name or the value.
        """
        try:
            for each in parameter_list:
                self._refuse_fixed(each)
            own = self._own(parameter_list)
            changed, held, reason = self._with(own) if len(own) == 1 else self._at_once(own)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        kinds = {name: each.kind for name, each in self._described.items()}
        implied = [Parameter(name, value=value) for name, value in self._implied(changed, own)]
        result = super().set_parameters_atomically(
            [_as_number(each, kinds.get(each.name)) for each in parameter_list] + implied
        )
        if result.successful:
            self.parameters, self.held, result.reason = changed, held, reason
            self.on_parameters()
        return result

    def _implied(self, changed: G, own: Values) -> Iterator[tuple[str, Value]]:
        """Yield what changes with what was set, in variants that have no value of their own."""
        if changed.variants():
            before = flatten(self.parameters)
            for name, value in flatten(changed).items():
                if value != before[name] and name not in own:
                    yield name, value

    def _at_once(self, own: Values) -> tuple[G, Values, str]:
        """Return the parameters with some changed; what is held, those left out, stays held."""
        held = {name: value for name, value in self.held.items() if name not in own}
        return replace(self.parameters, own), held, ""

    def _with(self, own: Values) -> tuple[G, Values, str]:
        """Return the parameters with some changed together with those held, as far as allowed."""
        together = {**self.held, **own}
        try:
            return replace(self.parameters, together), {}, ""
        except CombinationError as error:
            for name, value in own.items():
                self._described[name].check(name, value)
            with contextlib.suppress(CombinationError):
                return self._at_once(own)
            return self.parameters, together, f"not in use yet: {error}"

    def _refuse_fixed(self, parameter: Parameter) -> None:
        if parameter.name in self._fixed:
            raise ParameterError(
                parameter.name,
                f"got {parameter.value!r}, but it is read at start-up only: "
                "restart the node with it",
            )

    def _own(self, changes: Iterable[Parameter]) -> Values:
        """Return the values of the group's parameters by name; rclpy's own are only checked."""
        own: Values = {}
        for each in changes:
            if each.name == "use_sim_time" and each.type_ != Parameter.Type.BOOL:
                raise ParameterError(each.name, f"got {each.value!r}, expected true or false")
            if not is_builtin(each.name):
                refuse(each.name, each.value, self._described)
                own[each.name] = each.value
        return own


def to_message(descriptor: Descriptor, fixed: bool) -> ParameterDescriptor:
    """Return a descriptor as ROS tools show it."""
    unit = f" [{descriptor.unit}]" if descriptor.unit else ""
    message = ParameterDescriptor(
        description=descriptor.text + unit,
        additional_constraints=descriptor.range,
        read_only=fixed,
    )
    if descriptor.kind is float:
        limits = FloatingPointRange(from_value=descriptor.low, to_value=descriptor.high)
        message.floating_point_range = [limits]
    elif descriptor.kind is int:
        whole = IntegerRange(from_value=int(descriptor.low), to_value=int(descriptor.high), step=1)
        message.integer_range = [whole]
    return message


def _builtin_in(text: str) -> str:
    return next(name for name in text.replace("'", " ").split() if is_builtin(name))


def _as_number(parameter: Parameter, kind: type | None) -> Parameter:
    if kind is float and parameter.type_ == Parameter.Type.INTEGER:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
    return parameter
