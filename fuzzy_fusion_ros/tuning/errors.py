# SPDX-License-Identifier: Apache-2.0
"""What a recording can lack."""

from __future__ import annotations

from fuzzy_fusion_ros.parameters.errors import FusionError


class TuneError(FusionError):
    """Nothing can be fitted to this recording."""
