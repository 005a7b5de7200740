# SPDX-License-Identifier: Apache-2.0
"""How good an estimate is: metrics against a truth, their table, and regressions of them."""
