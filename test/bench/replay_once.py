# SPDX-License-Identifier: Apache-2.0
"""Replays a bag and prints its peak memory: python -m bench.replay_once BAG OUTPUT."""

from __future__ import annotations

import sys
from pathlib import Path

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters


def main() -> None:
    """Print the largest resident memory, KiB; getrusage would count that of the parent too."""
    path, output = sys.argv[1:]
    with open_bag(path) as bag:
        replay(bag, output, Topics(), Parameters())
    status = Path("/proc/self/status").read_text(encoding="ascii")
    print(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM:")))


if __name__ == "__main__":
    main()
