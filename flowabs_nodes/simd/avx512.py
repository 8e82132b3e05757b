"""Operations that are single instructions of AVX-512 and short calculations on other processors.

They are parts of powers of 2, look-ups in small tables and inverse roots. Of the vector modules only this one differs
between the paths of :data:`~flowabs_nodes.simd.target.PATH`. All but :func:`approximate_rsqrt` return the same on both.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba.extending import intrinsic

from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import (
    LANES,
    Floats,
    constant,
    floats,
    floor,
    from_bits,
    ints,
    llvm_function,
    operation,
    sqrt,
    to_ints,
)
from flowabs_nodes.simd.target import PATH

_F, _I, _I32 = floats.llvm, ints.llvm, ir.IntType(32)

if PATH == "avx512":
    _16, _ALL, _DEFAULT = ir.IntType(16), ir.IntType(16)(-1), _I32(4)
    _reduce = llvm_function("llvm.x86.avx512.mask.reduce.ps.512", _F, _F, _I32, _F, _16, _I32)
    _scale = llvm_function("llvm.x86.avx512.mask.scalef.ps.512", _F, _F, _F, _F, _16, _I32)
    _permute = llvm_function("llvm.x86.avx512.permvar.si.512", _I, _I, _I)
    _nothing = constant(_F, 0.0)

    #: Return x - floor(x).
    fraction = operation([floats], floats, lambda b, x: _reduce(b, x, _I32(1), _nothing, _ALL, _DEFAULT))
    #: Return x 2^floor(y).
    scale_by_exp2_floor = operation([floats, floats], floats, lambda b, x, y: _scale(b, x, y, _nothing, _ALL, _DEFAULT))
    #: Return table[i & 15] in each lane, of a vector ``table`` of sixteen ints and a vector of indices i.
    table_lookup = operation([ints, ints], ints, lambda b, table, i: _permute(b, table, i))
    #: Return 1 / sqrt(x) of x > 0, with a relative error below 2^-13.
    _inverse_root = llvm_function("llvm.x86.avx512.rsqrt14.ps.512", _F, _F, _F, _16)
    approximate_rsqrt = operation([floats], floats, lambda b, x: _inverse_root(b, x, _nothing, _ALL))
else:

    @inlined
    def approximate_rsqrt(x: Floats) -> Floats:
        """Return 1 / sqrt(x) of x > 0, to the rounding."""
        return 1.0 / sqrt(x)

    @inlined
    def fraction(x: Floats) -> Floats:
        """Return x - floor(x)."""
        return x - floor(x)

    @inlined
    def scale_by_exp2_floor(x: Floats, y: Floats) -> Floats:
        """Return x 2^floor(y), for y from -126 up to 128."""
        return x * from_bits((to_ints(floor(y)) + 127) << 23)

    @intrinsic
    def table_lookup(typingctx: Any, table: Any, indices: Any) -> Any:
        """Return table[i & 15] in each lane, of a vector ``table`` of sixteen ints and a vector of indices i."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            result = ir.Constant(_I, ir.Undefined)
            for lane in range(LANES):
                i = builder.and_(builder.extract_element(values[1], _I32(lane)), _I32(LANES - 1))
                result = builder.insert_element(result, builder.extract_element(values[0], i), _I32(lane))
            return result

        return ints(ints, ints), generate
