"""Benchmarks: what this package costs, beside what it is measured against. ``make bench``."""
