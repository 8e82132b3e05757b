"""The vector layer: sixteen pixels at a time, as values that numba kernels calculate with.

``floats``, ``doubles``, ``ints`` and ``masks`` are sixteen float32, float64, int32 or bits side by side. Kernels write
``a * b + 1.0`` or ``select(a < b, a, b)`` and get vector instructions, where numba alone would have to be lucky.
Numbers beside vectors stand for sixteen of them; nothing turns into another kind by itself (:func:`to_floats`).

Everything here is LLVM's own vector language, which it translates for any processor, in pieces where registers are
shorter than sixteen floats. What AVX-512 has better is in :mod:`~flowabs_nodes.simd.avx512`.

How vectors are read and written: :mod:`~flowabs_nodes.simd.memory`.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic, lower_builtin, lower_cast, models, register_model, type_callable

from flowabs_nodes.simd.jit import inlined as inlined  # for whoever has everything from here

LANES = 16

_I32, _I64, _F32, _F64 = ir.IntType(32), ir.IntType(64), ir.FloatType(), ir.DoubleType()
_FLOATS, _DOUBLES, _INTS, _MASKS = (ir.VectorType(element, LANES) for element in (_F32, _F64, _I32, ir.IntType(1)))
_CONTRACT = ("contract",)
LOW = 0 if sys.byteorder == "little" else 1  # which half of 64 bits comes first in memory


class Vector(types.Type):  # type: ignore[misc]
    """The numba type of sixteen ``element``."""

    def __init__(self, name: str, element: Any, llvm: Any) -> None:
        super().__init__(name)
        self.element, self.llvm = element, llvm


floats = Vector("floats", types.float32, _FLOATS)
doubles = Vector("doubles", types.float64, _DOUBLES)
ints = Vector("ints", types.int32, _INTS)
masks = Vector("masks", types.boolean, _MASKS)


@register_model(Vector)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, fe_type.llvm)


def _same(builder: Any, scalar: Any) -> Any:
    """``scalar`` in all lanes."""
    one = builder.insert_element(ir.Constant(ir.VectorType(scalar.type, LANES), ir.Undefined), scalar, _I32(0))
    return builder.shuffle_vector(one, one, ir.Constant(_INTS, [0] * LANES))


def constant(vector: Any, value: float) -> Any:
    return ir.Constant(vector, [value] * LANES)


@lower_cast(types.Number, Vector)
def _from_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    return _same(builder, context.cast(builder, value, fromty, toty.element))


def shuffled(builder: Any, x: Any, y: Any, lanes: Sequence[int]) -> Any:
    return builder.shuffle_vector(x, y, ir.Constant(ir.VectorType(_I32, len(lanes)), list(lanes)))


def joined(builder: Any, x: Any, y: Any) -> Any:
    return shuffled(builder, x, y, range(2 * x.type.count))


# Operators. ---------------------------------------------------------------------------------------------------------


def _operator(function: Any, result: Callable[[Any], Any], **generators: Any) -> None:
    """Declare ``function`` for vectors, how code for it is made given for ``floats``, ``ints`` or ``masks``.

    What is good for floats is good for doubles.
    """
    if "floats" in generators:
        generators["doubles"] = generators["floats"]

    def typed(*args: Any) -> Any:
        kinds = [arg for arg in args if isinstance(arg, Vector)]
        if not kinds or str(kinds[0]) not in generators:
            return None
        if any(not (arg is kinds[0] or isinstance(arg, types.Number)) for arg in args):
            return None
        return result(kinds[0])(*args)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = next(arg for arg in sig.args if isinstance(arg, Vector))
        vectors = [context.cast(builder, value, given, kind) for value, given in zip(args, sig.args, strict=True)]
        return generators[str(kind)](builder, *vectors)

    if function is operator.neg:
        type_callable(function)(lambda context: lambda x: typed(x))
        lower_builtin(function, Vector)(lower)
    else:
        type_callable(function)(lambda context: lambda x, y: typed(x, y))
        for kinds in ((Vector, Vector), (Vector, types.Number), (types.Number, Vector)):
            lower_builtin(function, *kinds)(lower)


def _same_kind(kind: Any) -> Any:
    return kind


_operator(
    operator.add,
    _same_kind,
    floats=lambda b, x, y: b.fadd(x, y, flags=_CONTRACT),
    ints=lambda b, x, y: b.add(x, y),
)
_operator(
    operator.sub,
    _same_kind,
    floats=lambda b, x, y: b.fsub(x, y, flags=_CONTRACT),
    ints=lambda b, x, y: b.sub(x, y),
)
_operator(
    operator.mul,
    _same_kind,
    floats=lambda b, x, y: b.fmul(x, y, flags=_CONTRACT),
    ints=lambda b, x, y: b.mul(x, y),
)
_operator(operator.truediv, _same_kind, floats=lambda b, x, y: b.fdiv(x, y, flags=_CONTRACT))
_operator(
    operator.neg,
    _same_kind,
    floats=lambda b, x: b.fneg(x),
    ints=lambda b, x: b.neg(x),
)
_operator(operator.and_, _same_kind, ints=lambda b, x, y: b.and_(x, y), masks=lambda b, x, y: b.and_(x, y))
_operator(operator.or_, _same_kind, ints=lambda b, x, y: b.or_(x, y), masks=lambda b, x, y: b.or_(x, y))
_operator(operator.xor, _same_kind, ints=lambda b, x, y: b.xor(x, y))
_operator(operator.lshift, _same_kind, ints=lambda b, x, y: b.shl(x, y))
_operator(operator.rshift, _same_kind, ints=lambda b, x, y: b.ashr(x, y))


def _comparison(function: Any, sign: str) -> None:
    _operator(
        function,
        lambda _: masks,
        floats=lambda b, x, y: b.fcmp_ordered(sign, x, y),
        ints=lambda b, x, y: b.icmp_signed(sign, x, y),
    )


_comparison(operator.lt, "<")
_comparison(operator.le, "<=")
_comparison(operator.gt, ">")
_comparison(operator.ge, ">=")
_comparison(operator.eq, "==")


# Functions of vectors. ----------------------------------------------------------------------------------------------


def operation(kinds: Sequence[Any], result: Any, generate: Callable[..., Any]) -> Any:
    """An operation on vectors of these kinds; numbers are taken for vectors. ``generate``: from builder and values."""

    def declare(*args: Any) -> Any:
        if any(not (arg is kind or isinstance(arg, types.Number)) for arg, kind in zip(args, kinds, strict=True)):
            return None
        return result(*kinds), lambda context, builder, sig, values: generate(builder, *values)

    if len(kinds) == 0:
        return intrinsic(lambda typingctx: declare())
    if len(kinds) == 1:
        return intrinsic(lambda typingctx, x: declare(x))
    return intrinsic(lambda typingctx, x, y: declare(x, y))


def llvm_function(name: str, result: Any, *kinds: Any) -> Callable[..., Any]:
    """Calls one of LLVM's own functions."""

    def generate(builder: Any, *values: Any) -> Any:
        return builder.call(declared(builder.module, name, ir.FunctionType(result, kinds)), values)

    return generate


def declared(module: Any, name: str, kind: Any) -> Any:
    """The function of that name, declared in ``module`` if it is not yet."""
    return module.globals.get(name) or ir.Function(module, kind, name)


#: Whole numbers only.
to_floats = operation([ints], floats, lambda b, x: b.sitofp(x, _FLOATS))
#: float32 as float64, which loses nothing, and back, to the nearest.
to_doubles = operation([floats], doubles, lambda b, x: b.fpext(x, _DOUBLES))
from_doubles = operation([doubles], floats, lambda b, x: b.fptrunc(x, _FLOATS))
#: The same bits as another kind.
bits_of = operation([floats], ints, lambda b, x: b.bitcast(x, _INTS))
from_bits = operation([ints], floats, lambda b, x: b.bitcast(x, _FLOATS))
same_floats = operation([floats], floats, lambda b, x: x)
same_doubles = operation([doubles], doubles, lambda b, x: x)
same_ints = operation([ints], ints, lambda b, x: x)
#: Sixteen whole numbers 0, 1 .. 15.
lane_numbers = operation([], ints, lambda b: ir.Constant(_INTS, list(range(LANES))))
#: Whether any lane is set.
any_lane = operation(
    [masks], types.boolean, lambda b, x: b.icmp_unsigned("!=", b.bitcast(x, ir.IntType(16)), ir.IntType(16)(0))
)


def _of_floats_or_doubles(name: str) -> Any:
    def declare(typingctx: Any, x: Any) -> Any:
        function = llvm_function(f"llvm.{name}.v16f{32 if x is floats else 64}", x.llvm, x.llvm)
        return x(x), lambda context, builder, sig, values: function(builder, *values)

    return intrinsic(declare)


sqrt = _of_floats_or_doubles("sqrt")
absolute = _of_floats_or_doubles("fabs")
floor = _of_floats_or_doubles("floor")
rint = _of_floats_or_doubles("rint")  # half to even


@intrinsic
def to_ints(typingctx: Any, x: Any) -> Any:
    """Floats or doubles without what comes after the point; they must be within int32."""
    return ints(x), lambda context, builder, sig, values: builder.fptosi(values[0], _INTS)


@intrinsic
def nearest_ints(typingctx: Any, x: Any) -> Any:
    """Doubles to the nearest whole numbers, half to even; modulo 2^32 if they are below 2^51."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        # In 2^52 + 2^51 + x the last bit counts ones: the whole number is the lower half of what it is made of.
        moved = builder.fadd(values[0], constant(_DOUBLES, 1.5 * 2.0**52))
        halves = builder.bitcast(moved, ir.VectorType(_I32, 2 * LANES))
        return shuffled(builder, halves, halves, range(LOW, 2 * LANES, 2))

    return ints(doubles), generate


@intrinsic
def prefix_sums(typingctx: Any, x: Any) -> Any:
    """Of ints: in each lane the sum of all up to it."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        total = values[0]
        for step in (1, 2, 4, 8):
            moved = shuffled(builder, constant(_INTS, 0), total, range(LANES - step, 2 * LANES - step))
            total = builder.add(total, moved)
        return total

    return ints(ints), generate


@intrinsic
def last_lane(typingctx: Any, x: Any) -> Any:
    """Ints of what is in the last lane."""
    last = [LANES - 1] * LANES
    return ints(ints), lambda context, builder, sig, values: shuffled(builder, values[0], values[0], last)


@intrinsic
def select(typingctx: Any, where: Any, then: Any, otherwise: Any) -> Any:
    """``then`` in the lanes of the mask, ``otherwise`` in the others."""
    kind = then if isinstance(then, Vector) else otherwise
    return kind(masks, kind, kind), lambda context, builder, sig, values: builder.select(*values)


def _first_if(sign: str) -> Any:
    """Of two vectors, or a vector and a number, in each lane the first one if the comparison holds, else the second."""

    def declare(typingctx: Any, x: Any, y: Any) -> Any:
        kind = x if isinstance(x, Vector) else y

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            compare = builder.icmp_signed if kind is ints else builder.fcmp_ordered
            return builder.select(compare(sign, *values), *values)

        return kind(kind, kind), generate

    return intrinsic(declare)


minimum, maximum = _first_if("<"), _first_if(">")
