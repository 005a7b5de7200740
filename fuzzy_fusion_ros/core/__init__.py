# SPDX-License-Identifier: Apache-2.0
"""The method: no ROS, no files, no clock, no global random state.

Read in the paper's order: ``membership``, ``aggregator``, ``predictor``, ``gate``, ``estimator``;
``conditioning`` of S1 before them and the ``observer`` in place of the blend are extensions.
Everything that a step needs is an argument and everything that it changes is in the state it
returns, so the same functions serve a node, a replay, a sweep and a fit.
"""
