# SPDX-License-Identifier: Apache-2.0
"""Complete jobs, from files to files: what a command does, and what a Python program calls."""
