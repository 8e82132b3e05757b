"""OpenCV, installed only with the extra ``compare``."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.errors import FlowabsError


def opencv(what: str) -> Any:
    """Return the module ``cv2``; raise FlowabsError if it is not installed, naming ``what`` needs it."""
    try:
        import cv2
    except ImportError as error:
        raise FlowabsError(
            f"{what} needs OpenCV, which is not installed",
            code="missing-package",
            hint="pip install flowabs-nodes[compare]",
        ) from error
    return cv2
