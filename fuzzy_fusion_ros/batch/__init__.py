# SPDX-License-Identifier: Apache-2.0
"""Whole recordings as arrays: the method run over them, and what they say about the sensors.

Loops are compiled where numba is installed.
"""
