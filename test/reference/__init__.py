# SPDX-License-Identifier: Apache-2.0
"""The method once more, written from its description alone: slow, obvious, and the judge.

Nothing here imports the package. The aggregator is in exact fractions, the predictor in plain
loops, the benchmark in one script-like run, so that each can be read beside the description.
"""
