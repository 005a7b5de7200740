"""Figures: drawn into files by matplotlib's Agg, never shown."""
