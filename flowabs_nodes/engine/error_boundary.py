"""Turns anything that goes wrong inside a node into an error of this package that says which node and frame."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from flowabs_nodes.errors import FlowabsError, InternalError, unforeseen
from flowabs_nodes.signals import asks_to_stop
from flowabs_nodes.simd.compatible import misfit

__all__ = ["InternalError", "error_boundary"]


@contextmanager
def error_boundary(node: str | None = None, frame: int | None = None) -> Iterator[None]:
    """Raise on whatever is raised inside as a :class:`FlowabsError` that knows its node and frame.

    A node may come from any package and fail in any way, by ``sys.exit`` too, and one frame must never stop the others,
    so this is the one place that catches everything. Only what stops the run passes: Stopped, and a KeyboardInterrupt
    that Ctrl-C may have raised (:func:`~flowabs_nodes.signals.asks_to_stop`).

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
    except BaseException as error:  # turned into ours and raised on, cause kept
        if isinstance(error, KeyboardInterrupt) and asks_to_stop(error):
            raise
        unfit = misfit(error)
        raise (unforeseen(error) if unfit is None else unfit).at(node=node, frame=frame) from error
