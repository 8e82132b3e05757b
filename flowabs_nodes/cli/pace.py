"""How fast frames are made, and how long the others will take."""

from __future__ import annotations

from collections import deque

_FRAMES = 20  # the last so many that were made count


class Pace:
    """Measures frames a second. Frames that are there already, or fail, are no measure.

    Nor is the first one, for which kernels are loaded or compiled, as soon as there is another. Times are in seconds,
    of any clock; ``start`` is when the first frame was begun.
    """

    def __init__(self, start: float) -> None:
        self._ends = deque([start], maxlen=_FRAMES + 1)
        self._made = 0

    def made(self, now: float) -> None:
        """Take note that a frame has been made."""
        self._ends.append(now)
        self._made += 1
        if self._made == 2:
            self._ends.popleft()

    def not_made(self, seconds: float) -> None:
        """Take note that a frame has ended that is no measure: the ``seconds`` that it took do not count."""
        self._ends = deque((end + seconds for end in self._ends), maxlen=_FRAMES + 1)

    @property
    def frames_per_second(self) -> float | None:
        """Return the frames made in a second; None as long as none has been made."""
        frames, seconds = len(self._ends) - 1, self._ends[-1] - self._ends[0]
        return frames / seconds if frames and seconds > 0 else None

    def left(self, frames: float, now: float) -> float | None:
        """Return the seconds until ``frames``, those not ended, are made; the one at work has begun with the last end.

        None as long as no frame has been made.
        """
        rate = self.frames_per_second
        if rate is None:
            return None
        return max(0.0, frames / rate - min(now - self._ends[-1], 1 / rate))
