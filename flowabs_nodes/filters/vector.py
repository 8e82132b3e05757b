"""The vector layer: sixteen pixels at a time, as values that numba kernels calculate with.

``floats``, ``doubles``, ``ints`` and ``masks`` are sixteen float32, float64, int32 or bits side by side. Kernels write
``a * b + 1.0`` or ``select(a < b, a, b)`` and get vector instructions, where numba alone would have to be lucky.
Numbers beside vectors stand for sixteen of them; nothing turns into another kind by itself (:func:`to_floats`).

Nearly everything here is LLVM's own vector language, which it translates for any processor, in pieces where registers
are shorter than sixteen floats. Three operations, :func:`exp2`, :func:`look_up` and :func:`rough_inverse_root`, are
other instructions where there is AVX-512 (:data:`~flowabs_nodes.filters.processor.PATH`).

Reading at scattered places is what the filters spend their time on. One load for each pixel, of a whole record of
neighbouring floats, and shuffling these into vectors beats the processors' own gather instructions by far; and the
addresses are best passed through memory, since taking them out of a vector one by one costs more than the loads.

What is worked out for one sixteen pixels after the other waits for loads; what goes through :func:`scratch`, a step for
many pixels and then the next step, does not (:func:`pairs_at`, :func:`quads_at`).

Arrays are one-dimensional float32, float64 or int32, or complex64 for pairs of floats; places in them count items, and
nothing is checked: whoever asks for sixteen floats from ``i`` on sees to it that they are there.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

from flowabs_nodes.filters.kernels import inlined as inlined  # for whoever has everything from here
from flowabs_nodes.filters.processor import PATH

LANES = 16

_I32, _I64, _F32, _F64 = ir.IntType(32), ir.IntType(64), ir.FloatType(), ir.DoubleType()
_FLOATS, _DOUBLES, _INTS, _MASKS = (ir.VectorType(element, LANES) for element in (_F32, _F64, _I32, ir.IntType(1)))
_CONTRACT = ("contract",)
_LOW = 0 if sys.byteorder == "little" else 1  # which half of 64 bits comes first in memory


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


def _constant(vector: Any, value: float) -> Any:
    return ir.Constant(vector, [value] * LANES)


@lower_cast(types.Number, Vector)
def _from_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    return _same(builder, context.cast(builder, value, fromty, toty.element))


# Operators. ---------------------------------------------------------------------------------------------------------


def _operator(function: Any, result: Callable[[Any], Any], **generators: Any) -> None:
    """Declare ``function`` for vectors, how code for it is made given for ``floats``, ``ints`` or ``masks``.

    What is good for floats is good for doubles.
    """
    if "floats" in generators:
        generators["doubles"] = generators["floats"]

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:
            kinds = [arg for arg in args if isinstance(arg, Vector)]
            if not kinds or str(kinds[0]) not in generators:
                return None
            if any(not (arg is kinds[0] or isinstance(arg, types.Number)) for arg in args):
                return None
            return signature(result(kinds[0]), *[kinds[0]] * len(args))

    infer_global(function)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return generators[str(sig.args[0])](builder, *args)

    lower_builtin(function, Vector)(lower)
    lower_builtin(function, Vector, Vector)(lower)


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


def _function(kinds: Sequence[Any], result: Any, generate: Callable[..., Any]) -> Any:
    """An operation on vectors of these kinds; numbers are taken for vectors. ``generate``: from builder and values."""

    def declare(*args: Any) -> Any:
        if any(not (arg is kind or isinstance(arg, types.Number)) for arg, kind in zip(args, kinds, strict=True)):
            return None
        return signature(result, *kinds), lambda context, builder, sig, values: generate(builder, *values)

    if len(kinds) == 0:
        return intrinsic(lambda typingctx: declare())
    if len(kinds) == 1:
        return intrinsic(lambda typingctx, x: declare(x))
    return intrinsic(lambda typingctx, x, y: declare(x, y))


def _call(name: str, result: Any, *kinds: Any) -> Callable[..., Any]:
    """Calls one of LLVM's own functions."""

    def generate(builder: Any, *values: Any) -> Any:
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(result, kinds), name)
        return builder.call(function, values)

    return generate


_multiply_add = _call("llvm.fmuladd.v16f32", _FLOATS, _FLOATS, _FLOATS, _FLOATS)

#: Whole numbers only.
to_floats = _function([ints], floats, lambda b, x: b.sitofp(x, _FLOATS))
#: float32 as float64, which loses nothing, and back, to the nearest.
to_doubles = _function([floats], doubles, lambda b, x: b.fpext(x, _DOUBLES))
from_doubles = _function([doubles], floats, lambda b, x: b.fptrunc(x, _FLOATS))
#: The same bits as another kind.
bits_of = _function([floats], ints, lambda b, x: b.bitcast(x, _INTS))
from_bits = _function([ints], floats, lambda b, x: b.bitcast(x, _FLOATS))
same_floats = _function([floats], floats, lambda b, x: x)
same_doubles = _function([doubles], doubles, lambda b, x: x)
same_ints = _function([ints], ints, lambda b, x: x)
#: Sixteen whole numbers 0, 1 .. 15.
lane_numbers = _function([], ints, lambda b: ir.Constant(_INTS, list(range(LANES))))
#: Whether any lane is set.
any_lane = _function(
    [masks], types.boolean, lambda b, x: b.icmp_unsigned("!=", b.bitcast(x, ir.IntType(16)), ir.IntType(16)(0))
)


def _of_floats_or_doubles(name: str) -> Any:
    def declare(typingctx: Any, x: Any) -> Any:
        function = _call(f"llvm.{name}.v16f{32 if x is floats else 64}", x.llvm, x.llvm)
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
        moved = builder.fadd(values[0], _constant(_DOUBLES, 1.5 * 2.0**52))
        halves = builder.bitcast(moved, ir.VectorType(_I32, 2 * LANES))
        return _shuffle(builder, halves, halves, range(_LOW, 2 * LANES, 2))

    return ints(doubles), generate


@intrinsic
def prefix_sums(typingctx: Any, x: Any) -> Any:
    """Of ints: in each lane the sum of all up to it."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        total = values[0]
        for step in (1, 2, 4, 8):
            moved = _shuffle(builder, _constant(_INTS, 0), total, range(LANES - step, 2 * LANES - step))
            total = builder.add(total, moved)
        return total

    return ints(ints), generate


@intrinsic
def last_lane(typingctx: Any, x: Any) -> Any:
    """Ints of what is in the last lane."""
    last = [LANES - 1] * LANES
    return ints(ints), lambda context, builder, sig, values: _shuffle(builder, values[0], values[0], last)


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


def _extreme(name: str) -> Any:
    reduce = _call(f"llvm.vector.reduce.{name}.v16f32", _F32, _FLOATS)
    return _function([floats], types.float32, lambda b, x: reduce(b, x))


#: The least and the greatest number of sixteen.
least_lane, greatest_lane = _extreme("fmin"), _extreme("fmax")


# Memory. ------------------------------------------------------------------------------------------------------------


def _place(context: Any, builder: Any, array_type: Any, array: Any, i: Any, pointee: Any) -> Any:
    data = array if isinstance(array_type, Memory) else context.make_array(array_type)(context, builder, array).data
    i = builder.sext(i, _I64) if i.type.width < 64 else i
    return builder.bitcast(builder.gep(data, [i]), pointee.as_pointer())


def _aligned_to_a_float(instruction: Any) -> Any:
    instruction.align = 4
    return instruction


def _kind_of(array: Any) -> Any:
    return {kind.element: kind for kind in (floats, doubles, ints)}[array.dtype]


@intrinsic
def load(typingctx: Any, array: Any, i: Any) -> Any:
    """array[i .. i + 15]: floats, doubles or ints, as the array is."""
    kind = _kind_of(array)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        return _aligned_to_a_float(builder.load(_place(context, builder, sig.args[0], values[0], values[1], kind.llvm)))

    return kind(array, i), generate


@intrinsic
def store(typingctx: Any, array: Any, i: Any, vector: Any) -> Any:
    """array[i .. i + 15] = vector."""
    kind = _kind_of(array)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        to, i, vector = values
        place = _place(context, builder, sig.args[0], to, i, kind.llvm)
        _aligned_to_a_float(builder.store(vector, place))
        return context.get_dummy_value()

    return types.void(array, i, kind), generate


class Memory(types.Type):  # type: ignore[misc]
    """The numba type of :func:`scratch` memory: of an array only where it begins, which compiles faster."""

    def __init__(self, dtype: Any) -> None:
        super().__init__(f"memory({dtype})")
        self.dtype = dtype


@register_model(Memory)
class _MemoryModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, manager.lookup(fe_type.dtype).get_value_type().as_pointer())


@intrinsic
def scratch(typingctx: Any, dtype: Any, count: Any) -> Any:
    """Memory for ``count`` (a constant) vectors on the stack of the kernel that asks, to load from and store to."""
    if not isinstance(count, types.IntegerLiteral):
        return None  # numba asks again with the constant

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        pointer = context.get_value_type(sig.return_type)
        memory = cgutils.alloca_once(builder, ir.ArrayType(pointer.pointee, LANES * count.literal_value))
        memory.align = 64
        return builder.bitcast(memory, pointer)

    return Memory(dtype.dtype)(dtype, count), generate


def _prefetcher(to_write: bool) -> Any:
    def declare(typingctx: Any, array: Any, i: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            byte = ir.IntType(8).as_pointer()
            place = _place(context, builder, sig.args[0], values[0], values[1], ir.IntType(8))
            prefetch = ir.FunctionType(ir.VoidType(), [byte, _I32, _I32, _I32])
            function = cgutils.get_or_insert_function(builder.module, prefetch, "llvm.prefetch.p0i8")
            builder.call(function, [place, _I32(int(to_write)), _I32(3), _I32(1)])
            return context.get_dummy_value()

        return types.void(array, i), generate

    return intrinsic(declare)


#: Have the line of memory of array[i] fetched that is read, or written, before long. Any i will do.
soon_read, soon_written = _prefetcher(False), _prefetcher(True)


def _shuffle(builder: Any, x: Any, y: Any, lanes: Sequence[int]) -> Any:
    return builder.shuffle_vector(x, y, ir.Constant(ir.VectorType(_I32, len(lanes)), list(lanes)))


def _join(builder: Any, x: Any, y: Any) -> Any:
    return _shuffle(builder, x, y, range(2 * x.type.count))


def _addresses(builder: Any, indices: Any) -> list[Any]:
    """Sixteen scalars from memory, two at a time: loads are what there is never enough of."""
    # An empty instruction that LLVM cannot look into: it would take the numbers out of the register after all.
    opaque = ir.InlineAsm(ir.FunctionType(_I64.as_pointer(), [_I64.as_pointer()]), "", "=r,0")
    first = builder.call(opaque, [builder.bitcast(indices, _I64.as_pointer())])
    two = [builder.load(builder.gep(first, [_I64(k)])) for k in range(LANES // 2)]
    return [
        builder.ashr(both, _I64(32)) if lane != _LOW else builder.sext(builder.trunc(both, _I32), _I64)
        for both in two
        for lane in range(2)
    ]


def _records(context: Any, builder: Any, sig: Any, values: Any, record: Any) -> list[Any]:
    """The record at array[i] for each of sixteen i in memory."""
    data = context.make_array(sig.args[0])(context, builder, values[0]).data
    indices = _place(context, builder, sig.args[1], values[1], values[2], _INTS)
    return [
        _aligned_to_a_float(builder.load(builder.bitcast(builder.gep(data, [i]), record.as_pointer())))
        for i in _addresses(builder, indices)
    ]


def _pairs(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    read = _records(context, builder, sig, values, _F64)  # 64 bits in one go, never calculated with
    halves = []
    for half in (read[:8], read[8:]):
        vector = ir.Constant(ir.VectorType(_F64, 8), ir.Undefined)
        for lane, number in enumerate(half):
            vector = builder.insert_element(vector, number, _I32(lane))
        halves.append(builder.bitcast(vector, _FLOATS))
    apart = [_shuffle(builder, halves[0], halves[1], range(k, 2 * LANES, 2)) for k in range(2)]
    return context.make_tuple(builder, sig.return_type, apart)


@intrinsic
def pairs_at(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """(array[i], array[i + 1]) for each i in places[k .. k + 15], as two vectors."""
    return types.UniTuple(floats, 2)(array, places, k), _pairs


def _quads(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    read = _records(context, builder, sig, values, ir.VectorType(_F32, 4))
    # Four vectors with records k, k + 4, k + 8, k + 12 each, then a 4 x 4 transpose in each quarter.
    rows = [
        _join(builder, _join(builder, read[k], read[k + 4]), _join(builder, read[k + 8], read[k + 12]))
        for k in range(4)
    ]
    return context.make_tuple(builder, sig.return_type, _transposed(builder, rows))


def _transposed(builder: Any, rows: Sequence[Any]) -> list[Any]:
    """Four vectors as 4 x 4 matrices, one in each quarter."""

    def mix(x: Any, y: Any, pattern: Sequence[int]) -> Any:
        return _shuffle(builder, x, y, [k % 4 + q + (k // 4) * LANES for q in range(0, LANES, 4) for k in pattern])

    low, high = (0, 4, 1, 5), (2, 6, 3, 7)
    p, q, r, s = rows
    a, b, c, d = mix(p, q, low), mix(r, s, low), mix(p, q, high), mix(r, s, high)
    first, second = (0, 1, 4, 5), (2, 3, 6, 7)
    return [mix(a, b, first), mix(a, b, second), mix(c, d, first), mix(c, d, second)]


@intrinsic
def quads_at(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """(array[i], array[i + 1], array[i + 2], array[i + 3]) for each i in places[k .. k + 15], as four vectors."""
    return types.UniTuple(floats, 4)(array, places, k), _quads


@intrinsic
def octets_at(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """(array[i], array[i + 1] .. array[i + 7]) for each i in places[k .. k + 15], as eight vectors."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        read = _records(context, builder, sig, values, ir.VectorType(_F32, 8))
        # A quarter of a vector is half a record: k, k, k + 4, k + 4. Four vectors are transposed in each quarter.
        rows = [_join(builder, read[k], read[k + 4]) for k in (0, 1, 2, 3, 8, 9, 10, 11)]
        low, high = _transposed(builder, rows[:4]), _transposed(builder, rows[4:])
        halves = [
            [
                _shuffle(builder, a, b, [q + k for q in range(4 * half, 2 * LANES, 8) for k in range(4)])
                for a, b in zip(low, high, strict=True)
            ]
            for half in range(2)
        ]
        return context.make_tuple(builder, sig.return_type, halves[0] + halves[1])

    return types.UniTuple(floats, 8)(array, places, k), generate


def _interleaved(size: int) -> tuple[Any, Any]:
    """Reading and writing sixteen neighbouring records of ``size`` floats, as ``size`` vectors."""

    @intrinsic
    def load_records(typingctx: Any, array: Any, i: Any) -> Any:
        """The sixteen records from array[i] on, one vector for each float of a record."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            joined = ir.VectorType(_F32, LANES * size)
            every = _aligned_to_a_float(
                builder.load(_place(context, builder, sig.args[0], values[0], values[1], joined))
            )
            return context.make_tuple(
                builder,
                sig.return_type,
                [_shuffle(builder, every, every, range(k, LANES * size, size)) for k in range(size)],
            )

        return types.UniTuple(floats, size)(array, i), generate

    @intrinsic
    def store_records(typingctx: Any, array: Any, i: Any, vectors: Any) -> Any:
        """Sixteen records from array[i] on, from a tuple of vectors."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            parts = cgutils.unpack_tuple(builder, values[2])
            joined = parts + [parts[-1]] * (size % 2)
            while len(joined) > 1:
                joined = [_join(builder, x, y) for x, y in zip(joined[::2], joined[1::2], strict=True)]
            lanes = [part * LANES + lane for lane in range(LANES) for part in range(size)]
            every = _shuffle(builder, joined[0], joined[0], lanes)
            _aligned_to_a_float(
                builder.store(every, _place(context, builder, sig.args[0], values[0], values[1], every.type))
            )
            return context.get_dummy_value()

        return types.void(array, i, vectors), generate

    return load_records, store_records


load_pairs, store_pairs = _interleaved(2)
load_triples, store_triples = _interleaved(3)
load_quads, store_quads = _interleaved(4)


# Where AVX-512 has something better. --------------------------------------------------------------------------------

if PATH == "avx512":
    _16, _ALL, _DEFAULT = ir.IntType(16), ir.IntType(16)(-1), _I32(4)
    _reduce = _call("llvm.x86.avx512.mask.reduce.ps.512", _FLOATS, _FLOATS, _I32, _FLOATS, _16, _I32)
    _scale = _call("llvm.x86.avx512.mask.scalef.ps.512", _FLOATS, _FLOATS, _FLOATS, _FLOATS, _16, _I32)
    _permute = _call("llvm.x86.avx512.permvar.si.512", _INTS, _INTS, _INTS)
    _nothing = _constant(_FLOATS, 0.0)

    #: x - floor(x), and x 2^floor(y).
    _fraction = _function([floats], floats, lambda b, x: _reduce(b, x, _I32(1), _nothing, _ALL, _DEFAULT))
    _scaled = _function([floats, floats], floats, lambda b, x, y: _scale(b, x, y, _nothing, _ALL, _DEFAULT))
    #: table[i & 15] for each i.
    look_up = _function([ints, ints], ints, lambda b, table, i: _permute(b, table, i))
    #: 1 / sqrt(x), to 2^-13 of it.
    _inverse_root = _call("llvm.x86.avx512.rsqrt14.ps.512", _FLOATS, _FLOATS, _FLOATS, _16)
    rough_inverse_root = _function([floats], floats, lambda b, x: _inverse_root(b, x, _nothing, _ALL))
else:

    @inlined
    def rough_inverse_root(x: Any) -> Any:
        return 1.0 / sqrt(x)

    @inlined
    def _fraction(x: Any) -> Any:
        return x - floor(x)

    @inlined
    def _scaled(x: Any, y: Any) -> Any:
        return x * from_bits((to_ints(floor(y)) + 127) << 23)

    @intrinsic
    def look_up(typingctx: Any, table: Any, indices: Any) -> Any:
        """table[i & 15] for each i."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            slot = cgutils.alloca_once(builder, _INTS)
            builder.store(values[0], slot)
            first = builder.bitcast(slot, _I32.as_pointer())
            indices, result = cgutils.alloca_once(builder, _INTS), ir.Constant(_INTS, ir.Undefined)
            builder.store(builder.and_(values[1], _constant(_INTS, 15)), indices)
            for lane, i in enumerate(_addresses(builder, indices)):
                result = builder.insert_element(result, builder.load(builder.gep(first, [i])), _I32(lane))
            return result

        return ints(ints, ints), generate


@inlined
def exp2(x: Any) -> Any:
    """2^x for x <= 0, to 4e-6 of its value; below -100, where nothing is left that would count, 2^-100.

    2^x = 2^floor(x) 2^f: the polynomial is the one of degree 4 with the least relative error on 0 <= f < 1.
    """
    x = maximum(x, -100.0)  # sums with numbers below 2^-126, which are held with fewer digits, are slow
    f = _fraction(x)
    power = f * 0.01353417 + 0.05201146
    power = power * f + 0.24144276
    power = power * f + 0.69300383
    power = power * f + 1.0000026
    return _scaled(power, x)
