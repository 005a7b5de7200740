"""Faults on purpose: what must never happen, tried until it would."""
