"""The paper's experiments: its methods over its sweeps, and its claims with intervals."""
