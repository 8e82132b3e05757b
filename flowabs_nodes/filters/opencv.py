"""OpenCV, which comes with the extra ``compare`` only."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.errors import FlowabsError


def opencv(what: str) -> Any:
    """The module ``cv2``, or an error that says how ``what`` gets it."""
    try:
        import cv2
    except ImportError as error:
        raise FlowabsError(
            f"{what} needs OpenCV, which is not installed",
            code="missing-package",
            hint="pip install flowabs-nodes[compare]",
        ) from error
    return cv2
