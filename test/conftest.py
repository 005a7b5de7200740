"""Set-up that all tests share."""

from __future__ import annotations

import signal

from hypothesis import HealthCheck, settings

# The same examples at every run, and no verdict that depends on how fast the machine is.
settings.register_profile(
    "reproducible",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("reproducible")

# Whoever runs the tests in the background has them ignore interrupts, and so what they start.
signal.signal(signal.SIGINT, signal.default_int_handler)
