"""Arrays that cannot be written to, and how kernels take them.

An image hands out its arrays read-only. To numba a read-only array is another type, for which it would compile every
kernel once more, and keep it on disk once more. So kernels get a writable view of the same memory
(:func:`~flowabs_nodes.simd.bands.over_rows`), which no Python code sees, and write only to arrays that they are given
to write to.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def read_only(array: Any) -> Any:
    """Return a view of ``array`` that cannot be written to; ``array`` stays as it is, and is returned if it cannot."""
    if not array.flags.writeable:
        return array
    view = array.view()
    view.flags.writeable = False
    return view


def for_kernel(argument: Any) -> Any:
    """Return an argument of a kernel with a writable view in place of each read-only array, in tuples too.

    Memory that nobody may write to, such as that of a ``bytes`` object or a file that is mapped for reading, is copied.
    """
    if isinstance(argument, np.ndarray):
        return argument if argument.flags.writeable else _writable(argument)
    if isinstance(argument, tuple):
        items = map(for_kernel, argument)
        return type(argument)(*items) if hasattr(argument, "_fields") else tuple(items)
    return argument


def _writable(array: Any) -> Any:
    """Return a writable view of a read-only array, or a copy where its memory is read-only too."""
    view = array.view()
    try:
        view.flags.writeable = True
    except ValueError:
        return array.copy()
    return view
