"""Plotly's figures as parts of a page that needs no network: the library packed into it once, arrays as base64."""

from __future__ import annotations

import base64
import gzip
import json
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

_UNPACK = """
let loaded;
const plotly = () => loaded ??= (async packed => {
  const bytes = Uint8Array.from(atob(packed), c => c.charCodeAt(0));
  const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  (0, eval)(text);  // in the global scope, as a script element would
  return window.Plotly;
})"""


@cache
def library_script() -> str:
    """JavaScript that defines `plotly()`, a promise of the library: 2 MB instead of 5, unpacked when asked."""
    from plotly.offline import get_plotlyjs

    packed = base64.b64encode(gzip.compress(get_plotlyjs().encode(), mtime=0)).decode("ascii")
    return f'{_UNPACK}("{packed}");'


def packed_array(values: ArrayLike, dtype: str = "f4") -> dict[str, str]:
    """An array as Plotly reads it from JSON.

    >>> packed_array([1.0, 2.0])
    {'dtype': 'f4', 'bdata': 'AACAPwAAAEA='}
    """
    data = np.ascontiguousarray(values, dtype=np.dtype(dtype).newbyteorder("<"))
    shape = {"shape": ", ".join(map(str, data.shape))} if data.ndim > 1 else {}
    return {"dtype": dtype, "bdata": base64.b64encode(data.tobytes()).decode("ascii")} | shape


def in_script(value: Any) -> str:
    """JSON that may stand in a script element: nothing in it ends the element or begins a comment."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
