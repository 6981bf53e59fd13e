"""What arrays hold, for annotations: each names the numbers, and a docstring the shape."""

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
