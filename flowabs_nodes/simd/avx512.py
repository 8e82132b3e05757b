"""What AVX-512 has instructions for, and other processors calculate: powers of 2, small tables, inverse roots.

The only place where the paths of :data:`~flowabs_nodes.simd.target.PATH` differ in the vector layer.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba.extending import intrinsic

from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import (
    LANES,
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

    #: x - floor(x), and x 2^floor(y).
    fraction = operation([floats], floats, lambda b, x: _reduce(b, x, _I32(1), _nothing, _ALL, _DEFAULT))
    scale_by_exp2_floor = operation([floats, floats], floats, lambda b, x, y: _scale(b, x, y, _nothing, _ALL, _DEFAULT))
    #: table[i & 15] for each i.
    table_lookup = operation([ints, ints], ints, lambda b, table, i: _permute(b, table, i))
    #: 1 / sqrt(x), to 2^-13 of it.
    _inverse_root = llvm_function("llvm.x86.avx512.rsqrt14.ps.512", _F, _F, _F, _16)
    approximate_rsqrt = operation([floats], floats, lambda b, x: _inverse_root(b, x, _nothing, _ALL))
else:

    @inlined
    def approximate_rsqrt(x: Any) -> Any:
        return 1.0 / sqrt(x)

    @inlined
    def fraction(x: Any) -> Any:
        return x - floor(x)

    @inlined
    def scale_by_exp2_floor(x: Any, y: Any) -> Any:
        return x * from_bits((to_ints(floor(y)) + 127) << 23)

    @intrinsic
    def table_lookup(typingctx: Any, table: Any, indices: Any) -> Any:
        """table[i & 15] for each i."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            result = ir.Constant(_I, ir.Undefined)
            for lane in range(LANES):
                i = builder.and_(builder.extract_element(values[1], _I32(lane)), _I32(LANES - 1))
                result = builder.insert_element(result, builder.extract_element(values[0], i), _I32(lane))
            return result

        return ints(ints, ints), generate
