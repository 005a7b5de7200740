# SPDX-License-Identifier: Apache-2.0
"""Reports of a recording as one self-contained page, for a browser without a network."""
