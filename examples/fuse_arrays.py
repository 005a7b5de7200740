# SPDX-License-Identifier: Apache-2.0
"""Fuses two numpy arrays: a fast, biased and noisy sensor with a slow, late and accurate one.

python examples/fuse_arrays.py
"""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros import Parameters, fuse, replace

PARAMETERS = replace(
    Parameters(),
    {
        "s1.lowpass_time_constant": 0.03,
        "s1.bias_time_constant": 10.0,
        "s2.noise": 0.01,
        "s2.lag_time_constant": 0.15,
        "s2.delay": 0.15,
    },
)
"""S1 low-passed and freed of its bias, which is learnt from S2 through its delay; tune finds
better."""


def main() -> None:
    """Print the RMS error of both sensors and of the estimate."""
    generator = np.random.default_rng(0)
    time_s = np.arange(0.0, 60.0, 0.01)
    slow_s = np.arange(0.0, 60.0, 0.2)
    s1 = signal(time_s) + 0.4 + 0.1 * generator.standard_normal(time_s.size)
    s2 = signal(slow_s - 0.3) + 0.01 * generator.standard_normal(slow_s.size)

    found = fuse(time_s, s1, slow_s, s2, parameters=PARAMETERS)

    held = s2[np.searchsorted(slow_s, time_s, side="right") - 1]
    print(f"S1        {rms(s1 - signal(time_s)):.3f}")
    print(f"S2, held  {rms(held - signal(time_s)):.3f}")
    print(f"estimate  {rms(found.value - signal(found.time_s)):.3f}")


def signal(time_s: np.ndarray) -> np.ndarray:
    """Return what both sensors measure."""
    return np.sin(0.5 * time_s) + 0.5 * np.sin(1.7 * time_s)


def rms(error: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(error))))


if __name__ == "__main__":
    main()
