# SPDX-License-Identifier: Apache-2.0
"""The executables: each file parses the arguments, calls one function and returns the status."""

COMMANDS = {
    "check": "find what is wrong with the two sensors of a bag",
    "demo": "score a real drive; balance a pendulum over DDS",
    "explain": "explain in words why an estimate is what it is",
    "fusion_node": "fuse two topics into one, online",
    "pendulum_node": "simulate the paper's pendulum, balanced on the estimate",
    "replay": "run a bag through the fusion, or play it live",
    "reproduce": "reproduce the paper's figures and claims",
    "score": "score the estimate, the sensors and other filters",
    "sensor_subscriber": "extract, validate and republish one number",
    "tune": "fit the parameters to a recording",
}
"""The commands and what each does; the file of the same name holds it."""
