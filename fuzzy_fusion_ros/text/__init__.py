# SPDX-License-Identifier: Apache-2.0
"""Plain text for terminals and for the comments of files."""
