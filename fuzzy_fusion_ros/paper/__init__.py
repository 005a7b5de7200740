"""The paper, reproduced: its methods over its sweeps, and every claim with its interval."""
