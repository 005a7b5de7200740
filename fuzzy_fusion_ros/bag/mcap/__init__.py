# SPDX-License-Identifier: Apache-2.0
"""MCAP files: a reader that recovers what is intact in a damaged file, and a writer."""
