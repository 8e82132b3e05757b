"""Reading and writing vectors: sixteen neighbouring items, or a record at each of sixteen scattered indices.

The filters spend most of their time in gathers (reads at scattered indices). A *record* is the few neighbouring floats
of one pixel. One load per pixel of its whole record, shuffled into vectors afterwards, is much faster than the
processors' own gather instructions. Indices come from memory, not from a vector: extracting sixteen of them from a
vector costs more than the loads themselves.

A kernel that takes one block of sixteen pixels through all its steps waits for each load. A kernel that takes many
blocks through one step, keeps the state in :func:`scratch` memory and then takes them through the next step does not.

Arrays are one-dimensional: float32, float64 or int32, or complex64 for pairs of floats. Indices count items of the
array. No bounds are checked: the caller makes sure that the items exist.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic, models, register_model

from flowabs_nodes.simd.lanes import LANES, LOW, concatenated, declared, doubles, floats, ints, shuffled

_I32, _I64, _F32, _F64 = ir.IntType(32), ir.IntType(64), ir.FloatType(), ir.DoubleType()


def _address(context: Any, builder: Any, array_type: Any, array: Any, i: Any, pointee: Any) -> Any:
    """Return the address of array[i], of an array or scratch memory, as an LLVM pointer to ``pointee``."""
    data = array if isinstance(array_type, Scratch) else context.make_array(array_type)(context, builder, array).data
    i = builder.sext(i, _I64) if i.type.width < 64 else i
    return builder.bitcast(builder.gep(data, [i]), pointee.as_pointer())


def _aligned_to_a_float(instruction: Any) -> Any:
    """Return a load or a store, told that its address is a multiple of four bytes and perhaps of no more."""
    instruction.align = 4
    return instruction


def _kind_of(array: Any) -> Any:
    """Return the kind of vector that holds items of ``array``, a numba type."""
    return {kind.element: kind for kind in (floats, doubles, ints)}[array.dtype]


@intrinsic
def load(typingctx: Any, array: Any, i: Any) -> Any:
    """Return array[i .. i + 15] as floats, doubles or ints, by the dtype of the array."""
    kind = _kind_of(array)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        return _aligned_to_a_float(
            builder.load(_address(context, builder, sig.args[0], values[0], values[1], kind.llvm))
        )

    return kind(array, i), generate


@intrinsic
def store(typingctx: Any, array: Any, i: Any, vector: Any) -> Any:
    """Write ``vector`` to array[i .. i + 15]."""
    kind = _kind_of(array)

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        to, i, vector = values
        place = _address(context, builder, sig.args[0], to, i, kind.llvm)
        _aligned_to_a_float(builder.store(vector, place))
        return context.get_dummy_value()

    return types.void(array, i, kind), generate


class Scratch(types.Type):  # type: ignore[misc]
    """The numba type of :func:`scratch` memory: only its address, where numba's arrays also carry shape and strides.

    Kernels compile faster with it.
    """

    def __init__(self, dtype: Any) -> None:
        super().__init__(f"memory({dtype})")
        self.dtype = dtype


@register_model(Scratch)
class _ScratchModel(models.PrimitiveModel):  # type: ignore[misc]
    """Tells numba that scratch memory is a pointer to its first item."""

    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, manager.lookup(fe_type.dtype).get_value_type().as_pointer())


@intrinsic
def scratch(typingctx: Any, dtype: Any, count: Any) -> Any:
    """Return memory on the kernel's stack for ``count`` vectors of ``dtype``, not initialised.

    ``count`` is a constant. The memory is indexed by items, like an array: its k-th vector begins at index 16 k.
    """
    if not isinstance(count, types.IntegerLiteral):
        return None  # numba then asks again, with the constant

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        pointer = context.get_value_type(sig.return_type)
        array = ir.ArrayType(pointer.pointee, LANES * count.literal_value)
        with builder.goto_entry_block():  # once, also where it is asked for in a loop
            memory = builder.alloca(array)
            memory.align = 64
            builder.store(array(None), memory)  # as numba does with all of its variables
        return builder.bitcast(memory, pointer)

    return Scratch(dtype.dtype)(dtype, count), generate


@intrinsic
def address(typingctx: Any, array: Any, i: Any) -> Any:
    """Return the memory of an array from array[i] on, to be passed on and indexed as that of :func:`scratch` is.

    In it is nothing but an address: to hand an array, or a tuple of arrays, from function to function numba counts
    references, which in an inner loop takes longer than what is read. An array of the function's own is freed after it
    is last named, used or not: :func:`keep` names it at the end.
    """

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        item = context.get_value_type(sig.return_type).pointee
        return _address(context, builder, sig.args[0], values[0], values[1], item)

    return Scratch(array.dtype)(array, i), generate


@intrinsic
def keep(typingctx: Any, array: Any) -> Any:
    """Do nothing, where the memory of ``array`` is last read or written by its :func:`address`."""
    return types.void(array), lambda context, builder, sig, values: context.get_dummy_value()


def _prefetcher(to_write: bool) -> Any:
    """Return a function that asks the processor to fetch an item of an array into the cache, for use in kernels."""

    def declare(typingctx: Any, array: Any, i: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            byte = ir.IntType(8).as_pointer()
            place = _address(context, builder, sig.args[0], values[0], values[1], ir.IntType(8))
            prefetch = ir.FunctionType(ir.VoidType(), [byte, _I32, _I32, _I32])
            function = declared(builder.module, "llvm.prefetch.p0i8", prefetch)
            builder.call(function, [place, _I32(int(to_write)), _I32(3), _I32(1)])
            return context.get_dummy_value()

        return types.void(array, i), generate

    return intrinsic(declare)


#: Ask for the cache line of array[i], which is soon read, or written. This is only a hint: i may be out of bounds.
prefetch, prefetch_for_write = _prefetcher(False), _prefetcher(True)


def _addresses(builder: Any, indices: Any) -> list[Any]:
    """Return sixteen int32 from memory as scalars, loaded two at a time: the number of loads limits the speed."""
    # LLVM cannot see through this empty instruction. Otherwise it would extract the numbers from a vector after all.
    opaque = ir.InlineAsm(ir.FunctionType(_I64.as_pointer(), [_I64.as_pointer()]), "", "=r,0")
    first = builder.call(opaque, [builder.bitcast(indices, _I64.as_pointer())])
    two = [builder.load(builder.gep(first, [_I64(k)])) for k in range(LANES // 2)]
    return [
        builder.ashr(both, _I64(32)) if lane != LOW else builder.sext(builder.trunc(both, _I32), _I64)
        for both in two
        for lane in range(2)
    ]


def _records(context: Any, builder: Any, sig: Any, values: Any, record: Any) -> list[Any]:
    """Return the ``record`` (an LLVM type) at array[i] for each of the sixteen i in places[k .. k + 15]."""
    data = _address(context, builder, sig.args[0], values[0], _I64(0), context.get_value_type(sig.args[0].dtype))
    indices = _address(context, builder, sig.args[1], values[1], values[2], ints.llvm)
    return [
        _aligned_to_a_float(builder.load(builder.bitcast(builder.gep(data, [i]), record.as_pointer())))
        for i in _addresses(builder, indices)
    ]


def _pairs(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    """Generate :func:`gather_pairs`."""
    read = _records(context, builder, sig, values, _F64)  # a pair is moved as 64 bits, never calculated with
    halves = []
    for half in (read[:8], read[8:]):
        vector = ir.Constant(ir.VectorType(_F64, 8), ir.Undefined)
        for lane, number in enumerate(half):
            vector = builder.insert_element(vector, number, _I32(lane))
        halves.append(builder.bitcast(vector, floats.llvm))
    apart = [shuffled(builder, halves[0], halves[1], range(k, 2 * LANES, 2)) for k in range(2)]
    return context.make_tuple(builder, sig.return_type, apart)


@intrinsic
def gather_pairs(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """Return two vectors: array[i] and array[i + 1], counted in floats, for each i in places[k .. k + 15].

    Of a complex64 array, i counts pairs: the vectors are the real and imaginary parts of array[i].
    """
    return types.UniTuple(floats, 2)(array, places, k), _pairs


def _quads(context: Any, builder: Any, sig: Any, values: Any) -> Any:
    """Generate :func:`gather_quads`."""
    read = _records(context, builder, sig, values, ir.VectorType(_F32, 4))
    # Four vectors with records k, k + 4, k + 8, k + 12 each, then a 4 x 4 transpose in each quarter.
    rows = [
        concatenated(
            builder, concatenated(builder, read[k], read[k + 4]), concatenated(builder, read[k + 8], read[k + 12])
        )
        for k in range(4)
    ]
    return context.make_tuple(builder, sig.return_type, _transposed(builder, rows))


def _transposed(builder: Any, rows: Sequence[Any]) -> list[Any]:
    """Return four vectors with their quarters transposed: quarter q of the four is a 4 x 4 matrix, for each q."""

    def mix(x: Any, y: Any, pattern: Sequence[int]) -> Any:
        return shuffled(builder, x, y, [k % 4 + q + (k // 4) * LANES for q in range(0, LANES, 4) for k in pattern])

    low, high = (0, 4, 1, 5), (2, 6, 3, 7)
    p, q, r, s = rows
    a, b, c, d = mix(p, q, low), mix(r, s, low), mix(p, q, high), mix(r, s, high)
    first, second = (0, 1, 4, 5), (2, 3, 6, 7)
    return [mix(a, b, first), mix(a, b, second), mix(c, d, first), mix(c, d, second)]


@intrinsic
def gather_quads(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """Return four vectors: the floats array[i .. i + 3], for each i in places[k .. k + 15].

    Of a complex64 array, i counts pairs: the vectors are the parts of array[i] and of array[i + 1].
    """
    return types.UniTuple(floats, 4)(array, places, k), _quads


@intrinsic
def gather_octets(typingctx: Any, array: Any, places: Any, k: Any) -> Any:
    """Return eight vectors: the floats array[i .. i + 7], for each i in places[k .. k + 15]."""

    def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
        read = _records(context, builder, sig, values, ir.VectorType(_F32, 8))
        # A quarter of a vector is half a record: k, k, k + 4, k + 4. Four vectors are transposed in each quarter.
        rows = [concatenated(builder, read[k], read[k + 4]) for k in (0, 1, 2, 3, 8, 9, 10, 11)]
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
    """Return a function that reads, and one that writes, sixteen neighbouring records of ``size`` floats."""

    @intrinsic
    def load_records(typingctx: Any, array: Any, i: Any) -> Any:
        """Return the sixteen records from array[i] on as ``size`` vectors: the first floats, the second ..."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            all_of_them = ir.VectorType(_F32, LANES * size)
            every = _aligned_to_a_float(
                builder.load(_address(context, builder, sig.args[0], values[0], values[1], all_of_them))
            )
            return context.make_tuple(
                builder,
                sig.return_type,
                [shuffled(builder, every, every, range(k, LANES * size, size)) for k in range(size)],
            )

        return types.UniTuple(floats, size)(array, i), generate

    @intrinsic
    def store_records(typingctx: Any, array: Any, i: Any, vectors: Any) -> Any:
        """Write sixteen records from array[i] on. ``vectors`` holds their first floats, their second ..."""

        def generate(context: Any, builder: Any, sig: Any, values: Any) -> Any:
            parts = [builder.extract_value(values[2], part) for part in range(size)]
            parts += [parts[-1]] * (size % 2)
            while len(parts) > 1:
                parts = [concatenated(builder, x, y) for x, y in zip(parts[::2], parts[1::2], strict=True)]
            lanes = [part * LANES + lane for lane in range(LANES) for part in range(size)]
            every = shuffled(builder, parts[0], parts[0], lanes)
            _aligned_to_a_float(
                builder.store(every, _address(context, builder, sig.args[0], values[0], values[1], every.type))
            )
            return context.get_dummy_value()

        return types.void(array, i, vectors), generate

    return load_records, store_records


#: load_pairs(array, i) and store_pairs(array, i, (x, y)); triples and quads likewise.
load_pairs, store_pairs = _interleaved(2)
load_triples, store_triples = _interleaved(3)
load_quads, store_quads = _interleaved(4)
