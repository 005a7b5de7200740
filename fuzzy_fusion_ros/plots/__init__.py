# SPDX-License-Identifier: Apache-2.0
"""Figures: drawn into files by matplotlib's Agg, never shown."""
