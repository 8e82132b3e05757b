"""Computes previews in a thread: only what changed, the newest wish first, older ones given up."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any

from flowabs_nodes import Image, Session, load_graph
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.errors import Cancelled, FlowabsError
from flowabs_nodes.port_types import TYPES

from .fill_datablock import pixels_for
from .outputs import main_outputs
from .plates import layer_of, plate_of, with_picture
from .taken import Taken

#: Seconds without a new picture after which a run is no longer given up for a newer wish: else a slider that never
#: rests would show nothing.
PATIENCE = 0.25


@dataclass(frozen=True)
class Wish:
    """What to show: a graph's document on a picture, at a scale; ``output`` "" is the first one that it writes."""

    graph: dict[str, Any]
    picture: Taken
    output: str
    frame: int
    scale: float


@dataclass(frozen=True)
class Shown:
    """What became of a wish: pixels as Blender holds them, or the error; and the seconds that it took."""

    pixels: Array | None = None
    are_colors: bool = True
    error: FlowabsError | None = None
    seconds: float = 0.0


class PreviewWorker:
    """Fulfils wishes (:meth:`ask`) in a thread of its own, and hands out what is newest (:meth:`take`)."""

    def __init__(self, working: ColorSpace) -> None:
        self._working = working
        self._session: Session | None = None
        self._held: tuple[Taken, str, Image] | None = None
        self._wish: Wish | None = None
        self._shown: Shown | None = None
        self._fresh = time.monotonic()  # when the last picture was made
        self._busy = False
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="flowabs-preview", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Return whether there is anything to wait for."""
        with self._changed:
            return self._busy or self._wish is not None or self._shown is not None

    def ask(self, wish: Wish) -> None:
        """Take a wish in place of all earlier ones."""
        with self._changed:
            self._wish = wish
            overtaken = self._session if time.monotonic() - self._fresh < PATIENCE else None
            self._changed.notify()
        if overtaken is not None:
            overtaken.cancel()

    def take(self) -> Shown | None:
        """Return what was made since the last call; None where nothing was."""
        with self._changed:
            shown, self._shown = self._shown, None
            return shown

    def close(self, seconds: float = 2.0) -> None:
        """End the thread, and wait so long for it at most; let go of all pictures."""
        with self._changed:
            self._closed = True
            self._wish = None
            self._changed.notify()
        if self._session is not None:
            self._session.close()
        self._thread.join(seconds)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.wait_for(lambda: self._closed or self._wish is not None)
                if self._closed or self._wish is None:
                    return
                wish, self._wish, self._busy = self._wish, None, True
            start = time.monotonic()
            try:
                with error_boundary():
                    shown = self._fulfil(wish)
            except Cancelled:
                continue
            except FlowabsError as error:
                shown = Shown(error=error)
            with self._changed:
                now = time.monotonic()
                self._fresh = now
                if not self._closed:
                    self._shown = Shown(shown.pixels, shown.are_colors, shown.error, now - start)

    def _fulfil(self, wish: Wish) -> Shown:
        """Return the pixels for a wish. Raises FlowabsError, Cancelled where a newer one has come."""
        graph = load_graph(wish.graph)
        output = wish.output or main_outputs(graph)[0]
        image = self._read(wish.picture, layer_of(graph, plate_of(graph)))
        graph, given = with_picture(graph, image, passes=wish.picture.file)
        session = self._session
        if session is None:
            session = Session(graph, on_event=lambda event: None)
            with self._changed:
                self._session = session
                if self._closed:
                    raise Cancelled("closed")
        session.exchange(graph)
        session.given(given)
        made = session.run(output, wish.frame, wish.scale)[output]
        return Shown(pixels_for(made, self._working), TYPES[made.type].shown)

    def _read(self, picture: Taken, layer: str) -> Image:
        """Return the image of a picture, read once."""
        if self._held is None or self._held[0] is not picture or self._held[1] != layer:
            self._held = (picture, layer, picture.image(layer))
        return self._held[2]
