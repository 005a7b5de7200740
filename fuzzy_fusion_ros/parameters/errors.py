# SPDX-License-Identifier: Apache-2.0
"""What a user can get wrong: one small family of errors, each a single clear line.

Every message says what was given, what was expected and what to do. The command line turns any
:class:`FusionError` into exit status 2; nothing else does.
"""

from __future__ import annotations


class FusionError(Exception):
    """Base class of all errors caused by a user's input, arguments or set-up."""


class ParameterError(FusionError):
    """A parameter is unknown, of the wrong type or outside its range.

    ``name`` is the dotted name as far as it is known; owners further out add theirs with
    :meth:`under`.
    """

    def __init__(self, name: str, problem: str) -> None:
        super().__init__(f"parameter {name}: {problem}")
        self.name = name
        self.problem = problem

    def under(self, owner: str) -> ParameterError:
        """Return the same error with ``owner.`` before its name."""
        return type(self)(f"{owner}.{self.name}", self.problem)


class CombinationError(ParameterError):
    """Each parameter is allowed, but not in combination."""


class MessageError(FusionError):
    """A message type, a field path or a message does not fit what was asked of it."""


class StampError(MessageError):
    """The nanoseconds of a message's timestamp are a second or more."""


class BagError(FusionError):
    """A bag cannot be read, written, or lacks what was asked of it."""


class UsageError(FusionError):
    """The arguments of a command do not fit."""
