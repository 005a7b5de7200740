"""Bags: read whole or damaged ones, write new ones. The only user of rosbags and mcap."""

from fuzzy_fusion_ros.bag.qos import QosProfile
from fuzzy_fusion_ros.bag.reader import BagReader, open_bag
from fuzzy_fusion_ros.bag.topic import BagMessage, Definition, Topic
from fuzzy_fusion_ros.bag.typestore import BagTypes, jazzy_types, serialize
from fuzzy_fusion_ros.bag.writer import BagWriter

__all__ = [
    "BagMessage",
    "BagReader",
    "BagTypes",
    "BagWriter",
    "Definition",
    "QosProfile",
    "Topic",
    "jazzy_types",
    "open_bag",
    "serialize",
]
