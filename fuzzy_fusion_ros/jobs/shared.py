# SPDX-License-Identifier: Apache-2.0
"""Files that come with the package: recordings and parameter files."""

from __future__ import annotations

import os
import site
import sys
import sysconfig
from pathlib import Path

PACKAGE = "fuzzy_fusion_ros"


def shared_folders(name: str) -> list[Path]:
    """Return where a folder of shared files may be, the first choice first.

    That is beside the sources, else in ``share`` of a ROS installation or of a prefix of pip's:
    that of the system, of Python, or of the user.

    Args:
        name: The folder in the sources: ``bags`` or ``config``.
    """
    ros = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    prefixes = dict.fromkeys([*ros, sysconfig.get_path("data"), sys.prefix, site.getuserbase()])
    installed = [Path(prefix, "share", PACKAGE, name) for prefix in prefixes]
    return [Path(__file__).parents[2] / name, *installed]


def presets() -> Path:
    """Return the folder of the presets, from the working directory if they are below it.

    It is empty where there is none, and whole where the working directory was removed.
    """
    folders = [each / "presets" for each in shared_folders("config")]
    found = next((each for each in folders if each.is_dir()), Path())
    try:
        here = Path.cwd()
    except OSError:
        return found
    return found.relative_to(here) if found.is_relative_to(here) else found
