"""Measure a pipeline's peak memory above its plate's, in a process of its own: NumPy, numba and C++ all count.

``python -m tools.bench.memory NAME FILE.npy`` prints bytes per pixel, which is MB per megapixel.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from flowabs_nodes.errors import FlowabsError
from tools.bench.start import environment

if TYPE_CHECKING:
    from tools.bench.scene import Array

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def peak(name: str, rgb: Array) -> float | None:
    """Return a pipeline's peak memory above its plate, in MB per megapixel; None where the system does not tell."""
    import numpy as np

    if not _RESET.exists():
        return None
    with tempfile.TemporaryDirectory(prefix="flowabs-bench-") as folder:
        file = Path(folder) / "plate.npy"
        np.save(file, rgb)
        command = [sys.executable, "-m", "tools.bench.memory", name, str(file)]
        done = subprocess.run(command, env=environment(), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise FlowabsError(f"{name} failed in a process of its own: {done.stderr.strip()[-2000:]}", code="bench-failed")
    return float(done.stdout)


def _measure(name: str, file: str) -> float:
    import numpy as np

    from tools.bench.cases import PIPELINES, Plate

    # Libraries load and kernels compile on a corner of the picture, the same as the whole does: that is no memory of
    # the plate's.
    rgb = np.load(file)
    height, width, _ = rgb.shape
    small = PIPELINES[name](Plate(rgb[:64, :64].copy(), corner_of=(width, height)))
    small.run(small.fresh())
    case = PIPELINES[name](Plate(rgb))
    plate = case.fresh()
    del rgb
    _RESET.write_text("5", encoding="ascii")  # the peak starts again at what is there now
    before = _kilobytes("VmRSS")
    case.run(plate)
    return float((_kilobytes("VmHWM") - before) * 1024 / (width * height))


def _kilobytes(field: str) -> int:
    lines = _STATUS.read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(field + ":"))


if __name__ == "__main__":
    print(_measure(*sys.argv[1:]))
