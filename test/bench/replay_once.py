"""Replays a bag and tells its peak memory: python -m bench.replay_once BAG OUTPUT."""

from __future__ import annotations

import resource
import sys

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.bag.replay import replay
from fuzzy_fusion_ros.bag.roles import Topics
from fuzzy_fusion_ros.core.parameters import Parameters


def main() -> None:
    """Print the largest resident memory, KiB."""
    path, output = sys.argv[1:]
    with open_bag(path) as bag:
        replay(bag, output, Topics(), Parameters())
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


if __name__ == "__main__":
    main()
