# SPDX-License-Identifier: Apache-2.0
"""Benchmarks: what this package costs, beside what it is measured against. ``make bench``."""
