"""How the kernels that follow the flow go over a picture: rows in parallel, each row in blocks of columns.

A kernel does one small thing for all pixels of a block (a step of the walk, a reading, a weighting), then the next,
and keeps what lies between in :func:`scratch`. Each small thing is a loop over neighbouring pixels, without the
wraparound of negative indices, that LLVM turns into vector code. These functions are inlined (:data:`inline`) before
numba compiles them, because only inside one kernel does LLVM see that scratch memory overlaps with nothing else.

Two things to know about numba. Of a ``parallel=True`` function it drops stores to arrays that are held in a tuple, so
rows are kernels of their own. And its cache on disk looks at the file of the kernel alone: after a change to functions
that are inlined into other files, delete ``__pycache__/*.nb?`` here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

COLUMNS = 256  # a block and all of its scratch stay in the first-level cache

inline = njit(inline="always")

u = np.uintp  # what pixels are counted with: unsigned indices do not wrap around


class Block(NamedTuple):
    """``size`` pixels of row ``y``, from column ``x`` on, in a picture of ``width`` x ``height``."""

    x: int
    y: int
    size: Any  # unsigned, and so is what counts up to it
    width: int
    height: int


@inline
def first_pixel(block: Block) -> Any:
    return u(block.y * block.width + block.x)


@intrinsic
def scratch(typingctx: Any, dtype: Any, each: Any) -> Any:
    """Memory on the stack for ``each`` (a constant) numbers a pixel; not initialised, and gone with the kernel."""
    if not isinstance(each, types.IntegerLiteral):
        return None  # numba asks again with the constant
    array = types.Array(dtype.dtype, 1, "C")
    size = COLUMNS * each.literal_value

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = context.get_data_type(array.dtype)
        memory = cgutils.alloca_once(builder, ir.ArrayType(number, size))
        itemsize = context.get_constant(types.intp, context.get_abi_sizeof(number))
        value = context.make_array(array)(context, builder)
        populate_array(
            value,
            data=builder.bitcast(memory, number.as_pointer()),
            shape=(context.get_constant(types.intp, size),),
            strides=(itemsize,),
            itemsize=itemsize,
            meminfo=None,
        )
        return value._getvalue()

    return array(dtype, each), codegen
