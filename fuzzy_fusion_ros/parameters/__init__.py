# SPDX-License-Identifier: Apache-2.0
"""Parameters: groups that are described and checked, those of the fusion, and their YAML files."""
