"""Shows a run on a terminal: a bar that moves within a frame, with the node at work, frames/s and the time left."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

from flowabs_nodes.cli.pace import Pace
from flowabs_nodes.cli.progress import Again, Event, Lines, Loudness
from flowabs_nodes.cli.streams import SafeStream, one_line

if TYPE_CHECKING:
    from tqdm import tqdm

    from flowabs_nodes.engine.report import Report

_LAYOUT = "{desc}{percentage:3.0f}%|{bar}| {unit}"  # the unit stands for all words beside the bar
_REFRESH = 0.25  # seconds


class Bar(Lines):
    """Show a bar; notes and failures stand above it.

    A thread of its own draws it again four times a second, so that it lives while a node runs long. What the bar shows
    is changed and drawn under one lock.
    """

    def __init__(self, loudness: Loudness, again: Again) -> None:
        super().__init__(loudness, again)
        self._bar: tqdm[Any] | None = None
        self._lock = threading.RLock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._refresh, name="flowabs-bar", daemon=True)
        self._ended = 0
        self._progress: dict[int, float] = {}  # of the frames that are being made
        #: By frame: name, type, and since when it is at work, the innermost work last.
        self._at_work: dict[int, list[tuple[str, str, float]]] = {}
        self._pace = Pace(time.monotonic())

    def __exit__(self, *exception: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._close()

    def event(self, event: Event) -> None:
        """Show an event of the engine."""
        match event["event"]:
            case "start":
                self._begin(event)
            case "node":
                self._node(event)
        super().event(event)

    def _begin(self, event: Event) -> None:
        from tqdm import tqdm

        stream = sys.stderr.raw if isinstance(sys.stderr, SafeStream) else sys.stderr
        name = f"{one_line(event['graph'])} " if event["graph"] else ""
        self._bar = tqdm(
            total=max(1, event["frames"]), desc=name, unit="", bar_format=_LAYOUT, dynamic_ncols=True, file=stream
        )
        self._bar.desc = name  # without the colon that tqdm adds
        self._pace = Pace(time.monotonic())
        self._draw()
        self._thread.start()

    def _node(self, event: Event) -> None:
        """Take note of what is at work; the thread will show it."""
        with self._lock:
            at_work = self._at_work.setdefault(event["frame"], [])
            self._progress[event["frame"]] = event["progress"]
            if event["status"] == "started":
                type = f" ({one_line(event['type'])})" if event["type"] else ""
                at_work.append((one_line(event["node"]), type, time.monotonic()))
            elif at_work:
                at_work.pop()

    def frame(self, event: Event) -> None:
        """Move the bar on for a frame that has ended, and say why where it failed."""
        with self._lock:
            self._progress.pop(event["frame"], None)
            self._at_work.pop(event["frame"], None)
            self._ended += 1
            if event["status"] == "done":
                self._pace.made(time.monotonic())
            else:
                self._pace.not_made(event["seconds"])
        if event["status"] == "failed" or self.loudness == Loudness.VERBOSE:
            super().frame(event)
        self._draw()

    def line(self, text: str, *, error: bool = False) -> None:
        """Print one line above the bar."""
        with self._lock:
            if self._bar is not None:
                self._bar.clear(nolock=True)
            super().line(text, error=error)
            self._draw()

    def end(self, report: Report) -> None:
        """Leave the bar as it is, and show the summary below it."""
        with self._lock:
            self._at_work.clear()
        self._draw()
        self._close()
        super().end(report)

    # ------------------------------------------------------------------ drawing

    def _draw(self) -> None:
        """Draw the bar as things are now."""
        with self._lock:
            if self._bar is not None:
                self._bar.n = min(float(self._bar.total or 1), self._ended + sum(self._progress.values()))
                self._bar.unit = self._words(time.monotonic())
                self._bar.refresh(nolock=True)

    def _words(self, now: float) -> str:
        """Return what stands beside the bar: "3/24 frames, 0.52 frames/s, 0:40 left, frame 4: flow (etf) 1.2 s".

        On a narrow terminal what matters least is left out.
        """
        bar = self._bar
        assert bar is not None
        rate, left = self._pace.frames_per_second, self._pace.left(self._left, now)
        count = f"{self._ended}/{bar.total} frames"
        speed = "? frames/s" if rate is None else f"{rate:.2f} frames/s" if rate < 100 else f"{rate:.0f} frames/s"
        rest = [f"{'?' if left is None else clock(left)} left"] if self._left else []
        first = [(frame, works[-1]) for frame, works in self._at_work.items() if works][:1]
        long = [f"frame {frame}: {name}{type} {now - since:.1f} s" for frame, (name, type, since) in first]
        short = [f"frame {frame}: {name} {now - since:.1f} s" for frame, (name, type, since) in first]
        room = (bar.ncols or 200) - len(bar.desc) - len("100%|          | ")
        choices = ([count, speed, *rest, *long], [count, speed, *rest, *short], [count, *rest, *short], [count, *short])
        texts = [", ".join(words) for words in choices]
        return next((text for text in texts if len(text) <= room), texts[-1])

    @property
    def _left(self) -> int:
        """How many frames have not ended."""
        assert self._bar is not None
        return int(self._bar.total or 0) - self._ended

    def _refresh(self) -> None:
        """Draw the bar again and again, until it is closed."""
        while not self._over.wait(_REFRESH):
            self._draw()

    def _close(self) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()
        with self._lock:
            if self._bar is not None:
                self._bar.close()
                self._bar = None


def clock(seconds: float) -> str:
    """Return a time as on a clock: "0:07", "12:40", "3:05:00"."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
