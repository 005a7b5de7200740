# SPDX-License-Identifier: Apache-2.0
"""What the fusion does with bags: read a recording, replay it into a new bag."""
