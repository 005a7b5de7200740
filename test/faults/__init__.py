# SPDX-License-Identifier: Apache-2.0
"""Faults on purpose: what must never happen, tried until it would."""
