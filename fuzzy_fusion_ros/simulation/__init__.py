"""The benchmark: an inverted pendulum that is balanced on an estimate of its angle, method § 6.

Pure functions over named tuples, like ``core``; randomness comes in as an argument.
"""
