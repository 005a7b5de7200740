"""Whole jobs, from files to files: what a command does, and what a Python program calls."""
