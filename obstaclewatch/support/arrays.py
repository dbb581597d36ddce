"""Names for the arrays that annotations speak of; shapes stand in the docstrings."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Halves = NDArray[np.float16]
Complexes = NDArray[np.complex128]
SingleComplexes = NDArray[np.complex64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.int8]
Flags = NDArray[np.bool_]
Strings = NDArray[np.str_]
