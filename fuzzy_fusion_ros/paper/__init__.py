# SPDX-License-Identifier: Apache-2.0
"""The paper's experiments: its methods over its sweeps, and its claims with intervals."""
