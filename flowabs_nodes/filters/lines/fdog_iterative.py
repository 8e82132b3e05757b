"""Iterative FDoG (section 3.2): the lines of each pass are superimposed on the picture that the next pass filters."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FORMS
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.lines.fdog import Detector
from flowabs_nodes.filters.lines.soft_edges import SoftEdges
from flowabs_nodes.filters.lines.thin_lines import ThinLines
from flowabs_nodes.filters.lines.threshold import threshold
from flowabs_nodes.filters.lines.xdog import xdog, xdog_rho
from flowabs_nodes.simd.bands import over_rows


def fdog_iterative(
    code: npt.ArrayLike,
    flow: npt.ArrayLike,
    sigma_m: float = 3.0,
    sigma_c: float = 1.0,
    rho: float = 0.99,
    color_weight: float = 0.0,
    kernel: str = "separable",
    sampling: str = "bilinear",
    tau: float = 0.5,
    contrast: float | None = None,
    softness: float = 0.0,
    iterations: int = 3,
    pre_blur: float = 0.0,
    form: str = "paper",
    p: float = 20.0,
    epsilon: float = 0.0,
    phi: float = 0.01,
    color_sign: bool = False,
    evidence: float = 0.0,
    soft_lines: float = 0.0,
    soft_reach: float = 7.0,
    thin_lines: float = 0.0,
    working_scale: str = "full",
) -> tuple[Array, Array]:
    """Draw lines by several passes of FDoG: each pass filters the original picture with the last pass's ink over it.

    Ink is code value 0, in proportion to 1 - lines; the flow stays the same. From pass to pass lines grow together, and
    become harder and thicker.

    Parameters
    ----------
    code, flow, sigma_m, sigma_c, rho, color_weight, kernel, sampling, color_sign, soft_lines, soft_reach, thin_lines,
    working_scale
        As the parameters of :func:`~flowabs_nodes.filters.fdog`. What soft edges lack, and what thin lines get, is
        measured once, in the picture without ink, and added in each pass. For the ``working_scale`` "auto" and more
        than one pass 1/2 must also leave ``sigma_c`` and ``pre_blur`` 2.8 pixels together (the root of the sum of their
        squares), 1/4 twice as much.
    tau, contrast, softness
        As the parameters of :func:`~flowabs_nodes.filters.threshold`.
    iterations
        Number of passes, at least 1.
    pre_blur
        Sigma in pixels, 0 to 10,000, of a Gaussian blur of the picture that each pass filters.
    form, p, epsilon, phi
        "paper", or "xdog" for the lines of :func:`~flowabs_nodes.filters.xdog`: then p, epsilon and phi take the place
        of rho, tau, contrast and softness, and ``evidence`` counts as 0.
    evidence
        As the parameter of :func:`~flowabs_nodes.filters.fdog`, in the last pass alone: the ink of the others joins
        what belongs together, and finds it evidence.

    Returns
    -------
    Lines, (H, W) float32, 1 paper and 0 ink, and the response that they come from, (H, W): H, or D for "xdog". Both are
    the last pass's.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    code = validate.plane_or_planes("code", code, summed=True)
    flow = validate.flow_field(flow, code.shape)
    is_xdog = validate.choice("form", form, FORMS) == "xdog"
    rho = xdog_rho(p) if is_xdog else rho
    iterations = validate.whole("iterations", iterations, min=1)
    pre_blur = validate.number("pre_blur", pre_blur, min=0, max=10_000)
    detector = Detector.checked(
        sigma_m, sigma_c, rho, color_weight, kernel, sampling, color_sign, working_scale, iterations, pre_blur
    )
    soft = SoftEdges.checked(
        soft_lines,
        soft_reach,
        sigma_c=sigma_c,
        rho=rho,
        color_weight=color_weight,
        pre_blur=pre_blur,
        factor=detector.factor,
    )
    thin = ThinLines.checked(thin_lines, detector.taps, pre_blur, detector.factor)
    evidence = 0.0 if is_xdog else validate.number("evidence", evidence, min=0, max=1)

    sigma = pre_blur / detector.factor
    original, small_flow = detector.reduced(code, flow)

    def draw(planes: Array, size: tuple[int, ...], evidence: float = 0.0) -> tuple[Array, Array]:
        """Return lines and response of one pass, of the size that is worked on or of the full one."""
        if sigma > 0:
            blurred = np.empty_like(planes)
            for plane, result in zip(planes, blurred, strict=True):
                result[:] = blur(plane, sigma)
            planes = blurred
        response = detector.response(planes, small_flow, size, missing, evidence)
        if is_xdog:
            return xdog(response, p, epsilon, phi)
        return threshold(response, tau, contrast, softness), response

    missing = None if soft is None else soft.missing(original, small_flow)
    if thin is not None:
        missing = thin.added(missing, original, small_flow)
    picture = original
    for _ in range(iterations - 1):
        lines, _ = draw(picture, original.shape[1:])
        picture = _inked(original, lines)
    return draw(picture, code.shape[:2], evidence)


def _inked(original: Array, lines: Array) -> Array:
    """Return planes (C, H, W) with ink over them: multiplied by ``lines``, (H, W)."""
    picture = np.empty_like(original)

    def band(first: int, last: int) -> None:
        np.multiply(original[:, first:last], lines[first:last], out=picture[:, first:last])

    over_rows(band, lines.shape[0])
    return picture
