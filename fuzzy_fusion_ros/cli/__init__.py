# SPDX-License-Identifier: Apache-2.0
"""The executables: each file parses the arguments, calls one function and returns the status."""

COMMANDS = {
    "check": "what is wrong with two sensors of a bag",
    "demo": "a real drive scored; a pendulum balanced over DDS",
    "explain": "why an estimate is what it is, in words",
    "fusion_node": "fuse two topics into one, online",
    "pendulum_node": "simulate the paper's pendulum, balanced on the estimate",
    "replay": "run a bag through the fusion; --live: onto its topics",
    "reproduce": "the paper's figures and claims",
    "score": "errors of estimate, sensors and other filters",
    "sensor_subscriber": "one number from messages of any type, validated",
    "tune": "fit the parameters to a recording",
}
"""The commands and what each does; the file of the same name holds it."""
