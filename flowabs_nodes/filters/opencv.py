"""OpenCV, installed only with the extras ``compare`` and ``motion``."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.forks import IMPORTING

#: What pip installs OpenCV with: for what the paper compares itself with, or for optical_flow alone.
EXTRA, MOTION_EXTRA = "flowabs-nodes[compare]", "flowabs-nodes[motion]"


def opencv(what: str, extra: str = EXTRA) -> Any:
    """Return the module ``cv2``; raise FlowabsError if it is not installed, naming ``what`` needs it, and ``extra``."""
    try:
        with IMPORTING:
            import cv2
    except ImportError as error:
        found = "which is not installed" if error.name == "cv2" else f"which cannot be imported: {error}"
        raise FlowabsError(
            f"{what} needs OpenCV, {found}", code="missing-package", hint=f"pip install '{extra}'"
        ) from error
    return cv2
