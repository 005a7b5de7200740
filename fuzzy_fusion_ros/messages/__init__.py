"""Messages and samples: one set of functions for messages of rclpy and of rosbags."""

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.copying import copy_message
from fuzzy_fusion_ros.messages.field_path import FieldPath
from fuzzy_fusion_ros.messages.resolve import numeric_fields, resolve_field
from fuzzy_fusion_ros.messages.sample import copy_with, is_stamped, sample_from_message
from fuzzy_fusion_ros.messages.type_fields import FieldType, InstalledTypes, TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import (
    load_message_class,
    normalise_type_name,
    type_name_of,
)

__all__ = [
    "FieldPath",
    "FieldType",
    "InstalledTypes",
    "Sample",
    "TypeDescriptions",
    "copy_message",
    "copy_with",
    "is_stamped",
    "load_message_class",
    "normalise_type_name",
    "numeric_fields",
    "resolve_field",
    "sample_from_message",
    "type_name_of",
]
