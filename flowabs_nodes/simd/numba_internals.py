"""What we take from numba that has no public name, all of it: a compiled kernel taken apart, and put together again.

numba's own cache does the same, but prepares the whole compiler before it loads anything, which takes longer than all
kernels of a graph. Where a name is missing, :func:`available` says so, and numba's own cache serves.
"""

from __future__ import annotations

from typing import Any

try:
    from numba.core.compiler import CompileResult
    from numba.core.runtime import rtsys
    from numba.core.serialize import dumps

    _complete = all(map(callable, (CompileResult._rebuild, CompileResult._reduce, rtsys.initialize, dumps)))
except (ImportError, AttributeError):
    _complete = False


_locks: tuple[Any, ...]
try:
    from llvmlite.binding.ffi import lib as _llvm  # type: ignore[import-untyped]
    from numba.core.compiler_lock import global_compiler_lock

    _locks = (global_compiler_lock._lock, _llvm._lock._lock)
except (ImportError, AttributeError):
    _locks = ()


def compiler_locks() -> tuple[Any, ...]:
    """Return the locks that are held while anything is compiled or loaded, in the order in which they are taken."""
    return _locks


def available(dispatcher: Any) -> bool:
    """Return whether this numba has every name that this file uses."""
    return _complete and hasattr(dispatcher, "_cache") and hasattr(dispatcher.targetctx.codegen(), "magic_tuple")


def processor(codegen: Any) -> str:
    """Return triple, name and features of the processor that code is made for, as text."""
    return repr(codegen.magic_tuple())


def enclosed(function: Any) -> bytes:
    """Return what a function takes from the function around it, as bytes."""
    return bytes(dumps([cell.cell_contents for cell in function.__closure__ or ()]))


def freeze(sig: Any, compiled: Any) -> bytes | None:
    """Return a compiled kernel as bytes; None if it holds addresses of this process."""
    if getattr(compiled.library, "has_dynamic_globals", False):
        return None
    *content, environments = compiled._replace(type_annotation="")._reduce()  # the annotation is long, for people
    # One without constants is of no use, but loading it would import the module of numba that it is of.
    content.append(tuple(each for each in environments if each.consts))
    return bytes(dumps((sig, content)))


def prepare(context: Any) -> None:
    """Have what every compiled kernel calls at hand: counting of references, and memory."""
    # Not context.refresh(), as numba's cache does: that imports half of numba, which only compiling needs.
    rtsys.initialize(context)


def thaw(content: Any, context: Any) -> Any:
    """Return what :func:`freeze` took apart, once it is unpickled, as a compiled kernel of this process."""
    return CompileResult._rebuild(context, *content)
