# SPDX-License-Identifier: Apache-2.0
"""The benchmark: an inverted pendulum, balanced on an estimate of its angle.

Pure functions over named tuples, like ``core``; the source of randomness is an argument.
"""
