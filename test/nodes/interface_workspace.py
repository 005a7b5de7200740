# SPDX-License-Identifier: Apache-2.0
"""A workspace whose interface package nobody has: built by colcon, used only by child processes."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from building import colcon, run, sourced, spaces

HERE = Path(__file__).resolve().parent
PACKAGE = HERE.parent / "interfaces"
USER = HERE / "interface_user.py"

HEADED = "scratch_interfaces/msg/Float64Stamped"
"""``header`` and ``value``."""

BARE = "scratch_interfaces/msg/BareFloat64Stamped"
"""``stamp`` and ``data``."""


class Workspace(NamedTuple):
    """A built workspace.

    Attributes:
        environment: That of a shell that has sourced it.
    """

    environment: Mapping[str, str]

    def run(self, *command: str | Path, cwd: Path) -> str:
        """Run a command in such a shell and return what it prints.

        Raises:
            AssertionError: Its exit status is not 0.
        """
        return run(*command, cwd=cwd, environment=self.environment).stdout

    def use(self, job: str, **options: Any) -> Any:
        """Run a job of ``interface_user.py`` in such a shell and return its result."""
        return json.loads(self.run(sys.executable, USER, job, json.dumps(options), cwd=HERE))


def build(folder: Path) -> Workspace:
    """Build the interface package.

    It takes a C and a C++ compiler and the headers of this Python; all else is from PyPI, or of
    the ROS 2 Jazzy that is sourced.

    Args:
        folder: For all that the build makes.

    Raises:
        AssertionError: It cannot be built; the error holds what colcon says.
    """
    definitions = {
        "BUILD_TESTING": "OFF",
        "CMAKE_PROJECT_TOP_LEVEL_INCLUDES": PACKAGE / "wheels.cmake",
        "Python3_EXECUTABLE": sys.executable,
    }
    given = [f"-D{name}={value}" for name, value in definitions.items()]
    colcon("build", folder, *spaces(PACKAGE, folder), "--cmake-args", *given)
    return Workspace(sourced(folder))
