"""Turns anything that goes wrong inside a node into an error of this package that says which node and frame."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from flowabs_nodes.errors import FlowabsError, InternalError
from flowabs_nodes.simd.compatible import misfit

__all__ = ["InternalError", "error_boundary"]


@contextmanager
def error_boundary(node: str | None = None, frame: int | None = None) -> Iterator[None]:
    """Raise on whatever is raised inside as a :class:`FlowabsError` that knows its node and frame.

    A node may come from any package and fail in any way, and one frame must never stop the others, so this is the one
    place that catches every exception. KeyboardInterrupt and SystemExit pass.

    Raises
    ------
    FlowabsError
        The error that was raised inside, with node and frame where it had none.
    InternalError
        Any other exception, which is its cause.
    """
    try:
        yield
    except FlowabsError as error:
        raise error.at(node=node, frame=frame)  # noqa: B904 - the same error, with its place
    except MemoryError as error:
        message = f"not enough memory ({error})" if str(error) else "not enough memory"
        hint = "run fewer jobs at once, or at a smaller --scale"
        raise InternalError(message, code="out-of-memory", hint=hint, node=node, frame=frame) from error
    except Exception as error:  # turned into ours and raised on, cause kept
        if (unfit := misfit(error)) is not None:
            raise unfit.at(node=node, frame=frame) from error
        first_line = (str(error).strip().splitlines() or [""])[0][:300]
        raise InternalError(f"{type(error).__name__}: {first_line}", node=node, frame=frame) from error
