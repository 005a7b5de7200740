"""Fuzzy fusion of a fast, inaccurate sensor with an accurate, slow one."""
