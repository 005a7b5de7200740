# SPDX-License-Identifier: Apache-2.0
"""Messages and samples: serialised messages only, which nodes and bags have in common."""

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.codec import ScalarCodec, Template
from fuzzy_fusion_ros.messages.defaults import default_message
from fuzzy_fusion_ros.messages.field_path import FieldPath
from fuzzy_fusion_ros.messages.resolve import computed_fields, numeric_fields, resolve_field
from fuzzy_fusion_ros.messages.type_fields import FieldType, InstalledTypes, TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import (
    load_message_class,
    normalise_type_name,
)

__all__ = [
    "FieldPath",
    "FieldType",
    "InstalledTypes",
    "Sample",
    "ScalarCodec",
    "Template",
    "TypeDescriptions",
    "computed_fields",
    "default_message",
    "load_message_class",
    "normalise_type_name",
    "numeric_fields",
    "resolve_field",
]
