"""How loops are compiled: in one way, so that what numba itself adds to them is compiled once for all.

numba compiles its own parts, such as `np.empty` and `max`, anew for callers with other options.
"""

from __future__ import annotations

import numba

compiled = numba.njit(cache=True, error_model="numpy")
"""Decorator for a function of arrays and numbers; it is kept for the next start (`compile_cache`).

Divisions are those of numpy, which do not raise: a check before each would keep loops from being vectorised.
"""
