# SPDX-License-Identifier: Apache-2.0
"""The quality of an estimate: metrics against a truth, their table, and regression tests."""
