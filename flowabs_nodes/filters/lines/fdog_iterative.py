"""Iterative FDoG (section 3.2): the lines of each pass are superimposed on the picture that the next pass filters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FORMS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.gaussian_blur import separable
from flowabs_nodes.filters.lines.evidence import Evidence
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
    lone_lines: float = 0.0,
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
        squares), 1/4 twice as much. Evidence is looked for at 1/2 where they are 2.8 pixels together. Unless "full",
        responses are summed over some of the samples alone where ``pre_blur`` leaves nothing finer: of the streamline
        over every second or third pixel, of the gradient axis over every second (:func:`step_along
        <flowabs_nodes.filters.working_scale.step_along>` and its neighbour).
    tau, contrast, softness
        As the parameters of :func:`~flowabs_nodes.filters.threshold`.
    iterations
        Number of passes, at least 1.
    pre_blur
        Sigma in pixels, 0 to 10,000, of a Gaussian blur of the picture that each pass filters.
    form, p, epsilon, phi
        "paper", or "xdog" for the lines of :func:`~flowabs_nodes.filters.xdog`: then p, epsilon and phi take the place
        of rho, tau, contrast and softness, and ``evidence`` and ``lone_lines`` count as 0.
    evidence, lone_lines
        As the parameters of :func:`~flowabs_nodes.filters.fdog`, in the last pass alone: the ink of the others joins
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
    passes = Passes.checked(
        sigma_m,
        sigma_c,
        rho,
        color_weight,
        kernel,
        sampling,
        tau,
        contrast,
        softness,
        iterations,
        pre_blur,
        form,
        p,
        epsilon,
        phi,
        color_sign,
        evidence,
        soft_lines,
        soft_reach,
        thin_lines,
        lone_lines,
        working_scale,
    )
    return passes.draw(code, flow)


@dataclass(frozen=True)
class Passes:
    """The passes of iterative FDoG with their parameters checked."""

    detector: Detector
    soft: SoftEdges | None
    thin: ThinLines | None
    lines_of: Callable[[Array], tuple[Array, Array]]  # a response H: lines, and the response that they come from
    iterations: int
    pre_blur: float  # sigma in pixels of the size that is worked on
    evidence: Evidence | None

    @classmethod
    def checked(
        cls,
        sigma_m: float,
        sigma_c: float,
        rho: float,
        color_weight: float,
        kernel: str,
        sampling: str,
        tau: float,
        contrast: float | None,
        softness: float,
        iterations: int,
        pre_blur: float,
        form: str,
        p: float,
        epsilon: float,
        phi: float,
        color_sign: bool,
        evidence: float,
        soft_lines: float,
        soft_reach: float,
        thin_lines: float,
        lone_lines: float,
        working_scale: str,
    ) -> Passes:
        """Return the passes with the parameters of :func:`fdog_iterative`; raise ArgumentError for a bad one."""
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
            working_scale=working_scale,
            factor=detector.factor,
        )
        thin = ThinLines.checked(
            thin_lines,
            sigma_c=sigma_c,
            rho=rho,
            pre_blur=pre_blur,
            working_scale=working_scale,
            factor=detector.factor,
        )
        weighing = Evidence.checked(*((0.0, 0.0) if is_xdog else (evidence, lone_lines)))
        if is_xdog:
            lines_of = partial(xdog, p=p, epsilon=epsilon, phi=phi)
        else:
            lines_of = partial(_below, tau=tau, contrast=contrast, softness=softness)
        return cls(detector, soft, thin, lines_of, iterations, pre_blur / detector.factor, weighing)

    def draw(self, code: npt.ArrayLike, flow: npt.ArrayLike) -> tuple[Array, Array]:
        """Return what :func:`fdog_iterative` does. Of ``code`` nothing is held once it is reduced or laid out."""
        code = validate.plane_or_planes("code", code, summed=True)
        flow, size = validate.flow_field(flow, code.shape), code.shape[:2]
        original, flows = self.detector.reduced(code, flow)
        del code, flow
        missing, lines = None if self.soft is None else self.soft.missing(original, flows), None
        if self.thin is not None:
            missing = self.thin.added(missing, original, flows)
        for _ in range(self.iterations - 1):
            seen = original.shape[1:]
            lines, _ = self.lines_of(self.detector.response(self._seen(original, lines), flows, seen, missing))
        response = self.detector.response(self._seen(original, lines), flows, size, missing, self.evidence)
        del original, missing, lines
        return self.lines_of(response)

    def _seen(self, original: Array, lines: Array | None) -> Array:
        """Return the planes (C, H, W) that a pass filters: the original under the ink of ``lines``, and blurred."""
        if self.pre_blur == 0:
            return original if lines is None else _inked(original, lines)
        picture, weights = np.empty_like(original), gaussian.half(self.pre_blur)
        for plane, blurred in zip(original, picture, strict=True):
            separable(plane if lines is None else _inked(plane, lines), weights, blurred)
        return picture


def _below(response: Array, tau: float, contrast: float | None, softness: float) -> tuple[Array, Array]:
    """Return the lines of a response, and the response."""
    return threshold(response, tau, contrast, softness), response


def _inked(original: Array, lines: Array) -> Array:
    """Return a plane (H, W), or planes (C, H, W), with ink over them: multiplied by ``lines``, (H, W)."""
    picture = np.empty_like(original)

    def band(first: int, last: int) -> None:
        np.multiply(original[..., first:last, :], lines[first:last], out=picture[..., first:last, :])

    over_rows(band, lines.shape[0])
    return picture
