"""The method: no ROS, no files, no clock, no global random state.

Read in the paper's order: ``membership``, ``aggregator``, ``predictor``, ``gate``,
``estimator``. Everything a step needs comes in as arguments and everything it changes goes out
as a new state, so the same functions serve the node, a replay, a sweep and a fit.
"""
