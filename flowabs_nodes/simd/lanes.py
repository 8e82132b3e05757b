"""Vectors of sixteen numbers, one for each of sixteen pixels, as values that compiled kernels calculate with.

A vector has sixteen *lanes*. There are four kinds: ``floats`` (float32), ``doubles`` (float64), ``ints`` (int32) and
``masks`` (one bit, the result of a comparison). Kernels write ``a * b + 1.0`` or ``select(a < b, a, b)`` and always get
vector instructions; numba alone finds them in some loops and not in others. A number beside a vector counts as sixteen
equal lanes. No kind is converted to another implicitly: kernels call :func:`to_floats` and its neighbours.

The operations are written in LLVM's vector language, which LLVM translates for any processor. Where a register holds
fewer than sixteen floats, a vector takes several. Operations that AVX-512 has special instructions for are in
:mod:`~flowabs_nodes.simd.avx512`, and those that read and write vectors in :mod:`~flowabs_nodes.simd.memory`.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic, lower_builtin, lower_cast, models, register_model, type_callable

#: How many numbers a vector holds.
LANES = 16

# Annotations of vectors. A type checker cannot see what numba makes of them, so each stands for Any.
Floats = Any  #: sixteen lanes of float32
Doubles = Any  #: sixteen lanes of float64
Ints = Any  #: sixteen lanes of int32
Masks = Any  #: sixteen lanes of one bit, 1 where a comparison holds

_I32, _I64, _F32, _F64 = ir.IntType(32), ir.IntType(64), ir.FloatType(), ir.DoubleType()
_FLOATS, _DOUBLES, _INTS, _MASKS = (ir.VectorType(element, LANES) for element in (_F32, _F64, _I32, ir.IntType(1)))
_CONTRACT = ("contract",)  # lets LLVM make one instruction of a product and a sum

#: The position in memory of the lower half of 64 bits: 0, first, or 1, second.
LOW = 0 if sys.byteorder == "little" else 1


class Vector(types.Type):  # type: ignore[misc]
    """The numba type of a vector of sixteen ``element`` (a numba type), represented in LLVM by ``llvm``."""

    def __init__(self, name: str, element: Any, llvm: Any) -> None:
        super().__init__(name)
        self.element, self.llvm = element, llvm


floats = Vector("floats", types.float32, _FLOATS)
doubles = Vector("doubles", types.float64, _DOUBLES)
ints = Vector("ints", types.int32, _INTS)
masks = Vector("masks", types.boolean, _MASKS)


@register_model(Vector)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    """Tells numba that a vector is its LLVM type in memory and in registers alike."""

    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, fe_type.llvm)


def _splat(builder: Any, scalar: Any) -> Any:
    """Return a vector whose sixteen lanes all hold ``scalar``."""
    one = builder.insert_element(ir.Constant(ir.VectorType(scalar.type, LANES), ir.Undefined), scalar, _I32(0))
    return builder.shuffle_vector(one, one, ir.Constant(_INTS, [0] * LANES))


def constant(vector: Any, value: float) -> Any:
    """Return a constant of the LLVM type ``vector`` whose sixteen lanes all hold ``value``."""
    return ir.Constant(vector, [value] * LANES)


@lower_cast(types.Number, Vector)
def _from_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    """Return a number beside a vector as a vector of the same kind."""
    return _splat(builder, context.cast(builder, value, fromty, toty.element))


def shuffled(builder: Any, x: Any, y: Any, lanes: Sequence[int]) -> Any:
    """Return the vector of the given ``lanes`` of x and y, which are counted through: those of y follow those of x."""
    return builder.shuffle_vector(x, y, ir.Constant(ir.VectorType(_I32, len(lanes)), list(lanes)))


def concatenated(builder: Any, x: Any, y: Any) -> Any:
    """Return the vector that holds the lanes of x and then those of y."""
    return shuffled(builder, x, y, range(2 * x.type.count))


# Operators. ---------------------------------------------------------------------------------------------------------


def _operator(function: Any, result: Callable[[Any], Any], **generators: Any) -> None:
    """Declare the Python operator ``function`` for vectors.

    ``result`` maps the kind of the operands to the kind of the result. ``generators`` holds, for each kind that has the
    operator, a function that emits LLVM code for it; the one for ``floats`` serves ``doubles`` too.
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
    """Return the kind of the operands as the kind of the result."""
    return kind


_operator(
    operator.add, _same_kind, floats=lambda b, x, y: b.fadd(x, y, flags=_CONTRACT), ints=lambda b, x, y: b.add(x, y)
)
_operator(
    operator.sub, _same_kind, floats=lambda b, x, y: b.fsub(x, y, flags=_CONTRACT), ints=lambda b, x, y: b.sub(x, y)
)
_operator(
    operator.mul, _same_kind, floats=lambda b, x, y: b.fmul(x, y, flags=_CONTRACT), ints=lambda b, x, y: b.mul(x, y)
)
_operator(operator.truediv, _same_kind, floats=lambda b, x, y: b.fdiv(x, y, flags=_CONTRACT))
_operator(operator.neg, _same_kind, floats=lambda b, x: b.fneg(x), ints=lambda b, x: b.neg(x))
_operator(operator.and_, _same_kind, ints=lambda b, x, y: b.and_(x, y), masks=lambda b, x, y: b.and_(x, y))
_operator(operator.or_, _same_kind, ints=lambda b, x, y: b.or_(x, y), masks=lambda b, x, y: b.or_(x, y))
_operator(operator.xor, _same_kind, ints=lambda b, x, y: b.xor(x, y))
_operator(operator.lshift, _same_kind, ints=lambda b, x, y: b.shl(x, y))
_operator(operator.rshift, _same_kind, ints=lambda b, x, y: b.ashr(x, y))


def _comparison(function: Any, sign: str) -> None:
    """Declare the comparison ``function`` (``sign`` in LLVM) of floats, doubles or ints: false where one is NaN."""
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
    """Return a function of up to two vectors of the given ``kinds``, for use in kernels.

    A number may stand for a vector. ``generate(builder, *values)`` emits its LLVM code, ``result`` is its numba type.
    """

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
    """Return a generator (of :func:`operation`) of a call to LLVM's function ``name``, of the given LLVM types."""

    def generate(builder: Any, *values: Any) -> Any:
        return builder.call(declared(builder.module, name, ir.FunctionType(result, kinds)), values)

    return generate


def declared(module: Any, name: str, kind: Any) -> Any:
    """Return the function of that name, declared in ``module`` first if it is not yet."""
    return module.globals.get(name) or ir.Function(module, kind, name)


#: Convert ints to floats, to the nearest.
to_floats = operation([ints], floats, lambda b, x: b.sitofp(x, _FLOATS))
#: Convert floats to doubles, which is exact, and doubles to floats, to the nearest.
to_doubles = operation([floats], doubles, lambda b, x: b.fpext(x, _DOUBLES))
from_doubles = operation([doubles], floats, lambda b, x: b.fptrunc(x, _FLOATS))
#: Reinterpret the bits of floats as ints, and the bits of ints as floats.
bits_of = operation([floats], ints, lambda b, x: b.bitcast(x, _INTS))
from_bits = operation([ints], floats, lambda b, x: b.bitcast(x, _FLOATS))
#: Return a vector whose sixteen lanes all hold a number.
splat_floats = operation([floats], floats, lambda b, x: x)
splat_doubles = operation([doubles], doubles, lambda b, x: x)
splat_ints = operation([ints], ints, lambda b, x: x)
#: Return the ints 0, 1 .. 15.
lane_indices = operation([], ints, lambda b: ir.Constant(_INTS, list(range(LANES))))
#: Return whether any lane of a mask is set, a bool.
any_lane = operation(
    [masks], types.boolean, lambda b, x: b.icmp_unsigned("!=", b.bitcast(x, ir.IntType(16)), ir.IntType(16)(0))
)

#: Return which lanes of a mask are set: an int whose bit k stands for lane k (on little-endian processors).
set_lanes = operation([masks], types.int64, lambda b, x: b.zext(b.bitcast(x, ir.IntType(16)), _I64))


def _of_floats_or_doubles(name: str) -> Any:
    """Return LLVM's function ``name`` of one vector of floats or doubles, for use in kernels."""

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
    """Return floats or doubles as ints, rounded towards zero. They must be in the range of int32."""
    return ints(x), lambda context, builder, sig, values: builder.fptosi(values[0], _INTS)


@intrinsic
def round_to_ints(typingctx: Any, x: Any) -> Any:
    """Return doubles as ints, rounded to the nearest, half to even. Those below 2^51 in size wrap around at 2^32."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        # In 2^52 + 2^51 + x the last bit of the mantissa counts ones, so its lower 32 bits are the rounded x.
        moved = builder.fadd(values[0], constant(_DOUBLES, 1.5 * 2.0**52))
        halves = builder.bitcast(moved, ir.VectorType(_I32, 2 * LANES))
        return shuffled(builder, halves, halves, range(LOW, 2 * LANES, 2))

    return ints(doubles), generate


@intrinsic
def prefix_sums(typingctx: Any, x: Any) -> Any:
    """Return, in each lane, the sum of the ints x in all lanes up to and including it."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        total = values[0]
        for step in (1, 2, 4, 8):
            moved = shuffled(builder, constant(_INTS, 0), total, range(LANES - step, 2 * LANES - step))
            total = builder.add(total, moved)
        return total

    return ints(ints), generate


@intrinsic
def last_lane(typingctx: Any, x: Any) -> Any:
    """Return a vector whose sixteen lanes all hold the last lane of the ints x."""
    last = [LANES - 1] * LANES
    return ints(ints), lambda context, builder, sig, values: shuffled(builder, values[0], values[0], last)


@intrinsic
def select(typingctx: Any, where: Any, then: Any, otherwise: Any) -> Any:
    """Return ``then`` in the lanes where the mask ``where`` is set, ``otherwise`` in the others."""
    kind = then if isinstance(then, Vector) else otherwise
    return kind(masks, kind, kind), lambda context, builder, sig, values: builder.select(*values)


def _first_if(sign: str) -> Any:
    """Return a function of x and y, two vectors or a vector and a number: in each lane x if "x ``sign`` y", else y."""

    def declare(typingctx: Any, x: Any, y: Any) -> Any:
        kind = x if isinstance(x, Vector) else y

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            compare = builder.icmp_signed if kind is ints else builder.fcmp_ordered
            return builder.select(compare(sign, *values), *values)

        return kind(kind, kind), generate

    return intrinsic(declare)


#: Return the smaller, or the larger, of two numbers in each lane; the second where one of them is NaN.
minimum, maximum = _first_if("<"), _first_if(">")
