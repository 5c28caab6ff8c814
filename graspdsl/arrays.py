"""The array types that everything numeric shares."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
Flags = npt.NDArray[np.bool_]
Rows = np.ndarray[tuple[int], np.dtype[np.intp]]  # places in a leading axis
