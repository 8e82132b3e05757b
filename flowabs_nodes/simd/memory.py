"""Reading and writing vectors: sixteen neighbours, or a record at each of sixteen places.

Reading at scattered places is what the filters spend their time on. One load for each pixel, of a whole record of
neighbouring floats, and shuffling these into vectors beats the processors' own gather instructions by far; and the
addresses are best passed through memory, since taking them out of a vector one by one costs more than the loads.

What is worked out for one sixteen pixels after the other waits for loads; what goes through :func:`scratch`, a step for
many pixels and then the next step, does not (:func:`pairs_at`, :func:`quads_at`).

Arrays are one-dimensional float32, float64 or int32, or complex64 for pairs of floats; places in them count items, and
nothing is checked: whoever asks for sixteen floats from ``i`` on sees to it that they are there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic, models, register_model

from flowabs_nodes.simd.lanes import LANES, LOW, declared, doubles, floats, ints, joined, shuffled

_I32, _I64, _F32, _F64 = ir.IntType(32), ir.IntType(64), ir.FloatType(), ir.DoubleType()


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
        array = ir.ArrayType(pointer.pointee, LANES * count.literal_value)
        with builder.goto_entry_block():  # once, also where it is asked for in a loop
            memory = builder.alloca(array)
            memory.align = 64
            builder.store(array(None), memory)  # as numba does with all of its variables
        return builder.bitcast(memory, pointer)

    return Memory(dtype.dtype)(dtype, count), generate


def _prefetcher(to_write: bool) -> Any:
    def declare(typingctx: Any, array: Any, i: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            byte = ir.IntType(8).as_pointer()
            place = _place(context, builder, sig.args[0], values[0], values[1], ir.IntType(8))
            prefetch = ir.FunctionType(ir.VoidType(), [byte, _I32, _I32, _I32])
            function = declared(builder.module, "llvm.prefetch.p0i8", prefetch)
            builder.call(function, [place, _I32(int(to_write)), _I32(3), _I32(1)])
            return context.get_dummy_value()

        return types.void(array, i), generate

    return intrinsic(declare)


#: Have the line of memory of array[i] fetched that is read, or written, before long. Any i will do.
soon_read, soon_written = _prefetcher(False), _prefetcher(True)


def _addresses(builder: Any, indices: Any) -> list[Any]:
    """Sixteen scalars from memory, two at a time: loads are what there is never enough of."""
    # An empty instruction that LLVM cannot look into: it would take the numbers out of the register after all.
    opaque = ir.InlineAsm(ir.FunctionType(_I64.as_pointer(), [_I64.as_pointer()]), "", "=r,0")
    first = builder.call(opaque, [builder.bitcast(indices, _I64.as_pointer())])
    two = [builder.load(builder.gep(first, [_I64(k)])) for k in range(LANES // 2)]
    return [
        builder.ashr(both, _I64(32)) if lane != LOW else builder.sext(builder.trunc(both, _I32), _I64)
        for both in two
        for lane in range(2)
    ]


def _records(context: Any, builder: Any, sig: Any, values: Any, record: Any) -> list[Any]:
    """The record at array[i] for each of sixteen i in memory."""
    data = context.make_array(sig.args[0])(context, builder, values[0]).data
    indices = _place(context, builder, sig.args[1], values[1], values[2], ints.llvm)
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
        halves.append(builder.bitcast(vector, floats.llvm))
    apart = [shuffled(builder, halves[0], halves[1], range(k, 2 * LANES, 2)) for k in range(2)]
    return context.make_tuple(builder, sig.return_type, apart)


@intrinsic
def pairs_at(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """(array[i], array[i + 1]) for each i in places[k .. k + 15], as two vectors."""
    return types.UniTuple(floats, 2)(array, places, k), _pairs


def _quads(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    read = _records(context, builder, sig, values, ir.VectorType(_F32, 4))
    # Four vectors with records k, k + 4, k + 8, k + 12 each, then a 4 x 4 transpose in each quarter.
    rows = [
        joined(builder, joined(builder, read[k], read[k + 4]), joined(builder, read[k + 8], read[k + 12]))
        for k in range(4)
    ]
    return context.make_tuple(builder, sig.return_type, _transposed(builder, rows))


def _transposed(builder: Any, rows: Sequence[Any]) -> list[Any]:
    """Four vectors as 4 x 4 matrices, one in each quarter."""

    def mix(x: Any, y: Any, pattern: Sequence[int]) -> Any:
        return shuffled(builder, x, y, [k % 4 + q + (k // 4) * LANES for q in range(0, LANES, 4) for k in pattern])

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
        rows = [joined(builder, read[k], read[k + 4]) for k in (0, 1, 2, 3, 8, 9, 10, 11)]
        low, high = _transposed(builder, rows[:4]), _transposed(builder, rows[4:])
        halves = [
            [
                shuffled(builder, a, b, [q + k for q in range(4 * half, 2 * LANES, 8) for k in range(4)])
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
            all_of_them = ir.VectorType(_F32, LANES * size)
            every = _aligned_to_a_float(
                builder.load(_place(context, builder, sig.args[0], values[0], values[1], all_of_them))
            )
            return context.make_tuple(
                builder,
                sig.return_type,
                [shuffled(builder, every, every, range(k, LANES * size, size)) for k in range(size)],
            )

        return types.UniTuple(floats, size)(array, i), generate

    @intrinsic
    def store_records(typingctx: Any, array: Any, i: Any, vectors: Any) -> Any:
        """Sixteen records from array[i] on, from a tuple of vectors."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            parts = [builder.extract_value(values[2], part) for part in range(size)]
            parts += [parts[-1]] * (size % 2)
            while len(parts) > 1:
                parts = [joined(builder, x, y) for x, y in zip(parts[::2], parts[1::2], strict=True)]
            lanes = [part * LANES + lane for lane in range(LANES) for part in range(size)]
            every = shuffled(builder, parts[0], parts[0], lanes)
            _aligned_to_a_float(
                builder.store(every, _place(context, builder, sig.args[0], values[0], values[1], every.type))
            )
            return context.get_dummy_value()

        return types.void(array, i, vectors), generate

    return load_records, store_records


load_pairs, store_pairs = _interleaved(2)
load_triples, store_triples = _interleaved(3)
load_quads, store_quads = _interleaved(4)
