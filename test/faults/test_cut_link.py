# SPDX-License-Identifier: Apache-2.0
"""Two hosts, and the link between them cut."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from faults.cutting import cut_the_cable

# Where CI runs as root it has to be possible, and fails if it is not.
impossible = os.geteuid() != 0 or (shutil.which("ip") is None and os.environ.get("CI") != "true")


@pytest.mark.skipif(impossible, reason="network namespaces take root and iproute2")
def test_the_fusion_falls_back_on_what_is_near_and_comes_back(tmp_path: Path) -> None:
    estimates, _ = cut_the_cable(tmp_path / "bag", 1, seed=1)
    assert estimates > 100
