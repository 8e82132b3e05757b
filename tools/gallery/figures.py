"""The figures: each one's graph, its pictures, and its outputs side by side.

Parameters in captions come from the graph as it ran; numbers are measured on the very pictures shown.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from flowabs_nodes.image import Image
from tools.gallery import drawings, inputs, measures
from tools.gallery.sheet import display

Results = Mapping[str, Image]
Measure = Callable[[Results, str], Mapping[str, str]]


@dataclass(frozen=True)
class Panel:
    """One output of the graph, its title, and the parameters ("node.name") that its caption tells."""

    output: str
    title: str
    values: tuple[str, ...] = ()


@dataclass(frozen=True)
class Row:
    """Panels of one picture, or of a region ``box`` (x, y, width, height) of it, each pixel ``zoom`` wide."""

    picture: str
    panels: tuple[Panel, ...]
    box: tuple[int, int, int, int] | None = None
    zoom: int = 1
    columns: int | None = None  # the figure's, unless given


@dataclass(frozen=True)
class Figure:
    """A sheet of a graph's outputs; both have the same name."""

    name: str
    title: str
    rows: tuple[Row, ...]
    width: int = 300  # of a panel, at most
    columns: int = 4
    measure: Measure | None = None


# ---------------------------------------------------------------------------------------------- measured words


def pieces(*outputs: str) -> Measure:
    """Count the pieces of ink of each drawing, and measure their size."""

    def measure(results: Results, picture: str) -> Mapping[str, str]:
        found = {output: measures.ink_components(results[output].pixels[..., 0]) for output in outputs}
        return {
            name: f"{ink.pieces} piece{'s' * (ink.pieces > 1)} of {ink.mean_size:.0f} px" for name, ink in found.items()
        }

    return measure


def contour(*outputs: str) -> Measure:
    """Measure the F-score of each drawing against the true contour of the disc."""

    def measure(results: Results, picture: str) -> Mapping[str, str]:
        true = drawings.disc_contour()
        score = {output: measures.f_score(results[output].pixels[..., 0], true).f_score for output in outputs}
        return {name: f"F-score {value:.2f}" for name, value in score.items()}

    return measure


def distance(results: Results, picture: str) -> Mapping[str, str]:
    """Measure the mean colour distance of Fig. 5's two pictures, components 0 to 1."""
    apart = np.linalg.norm(results["full"].pixels - results["separable"].pixels, axis=2)
    return {"separable": f"mean colour distance {apart.mean():.3f}"}


def noise_ratio(*outputs: str) -> Measure:
    """Measure the PSNR of each picture against the undamaged photograph, in 8-bit display values."""

    def measure(results: Results, picture: str) -> Mapping[str, str]:
        true = inputs.clean(picture).astype(np.float64)
        errors = {output: np.mean((display(results[output]) - true) ** 2) for output in outputs}
        return {name: f"{10 * np.log10(255**2 / error):.1f} dB" for name, error in errors.items()}

    return measure


# ---------------------------------------------------------------------------------------------- the figures

INPUT = Panel("plate", "Input")
_DOG = ("sigma_c", "rho", "tau")
_FDOG = ("sigma_m", *_DOG)
_ITERATIVE = ("iterations", *_FDOG)
_XDOG = ("sigma_m", "sigma_c", "p", "epsilon", "phi")
_ETF = ("radius", "iterations")
_FBL = ("sigma_e", "r_e", "sigma_g", "r_g", "iterations")
_BILATERAL = ("sigma_d", "sigma_r", "iterations")


def of(node: str, *names: str) -> tuple[str, ...]:
    """Return the names of a node's parameters, as a caption names them."""
    return tuple(f"{node}.{name}" for name in names)


_ALL = of("lines", *_ITERATIVE) + of("smooth", *_FBL) + of("flat", "levels")
_COMBINED = (
    INPUT,
    Panel("lines", "Line extraction", of("lines", *_ITERATIVE)),
    Panel("flat", "Region flattening", of("smooth", *_FBL) + of("flat", "levels")),
    Panel("comp", "Combined"),
)
_FIRST_THIRD = (
    INPUT,
    Panel("dog", "Isotropic DoG", of("dog", *_DOG)),
    Panel("first", "FDoG: first iteration", of("first", *_FDOG)),
    Panel("third", "FDoG: third iteration"),
)
_DOTS = (
    INPUT,
    Panel("dog", "DoG", of("dog", *_DOG)),
    Panel("lic", "ETF", of("flow", *_ETF, "pre_blur")),
    Panel("fdog", "FDoG", of("fdog", *_FDOG)),
    Panel("third", "FDoG: third iteration", of("third", "pre_blur")),
)
_TEXTURE = (
    INPUT,
    Panel("mu_3", "FDoG: radius {flow_3.radius}", of("flow_3", "iterations")),
    Panel("mu_5", "FDoG: radius {flow_5.radius}", of("flow_5", "iterations")),
    Panel("adaptive", "FDoG: radius {flow_adaptive.radius}, adaptive", of("flow_adaptive", "iterations")),
)
_BIL = Panel("bilateral", "Bilateral filter", of("bilateral", *_BILATERAL))
_FLOW = Panel("lic", "ETF", of("flow", *_ETF))
_FLOW_BIL = Panel("fbl", "FBL", of("fbl", *_FBL))
_TEXTURES = (
    INPUT,
    Panel("bilateral_flat", "Bilateral", of("bilateral", *_BILATERAL) + of("bilateral_flat", "levels")),
    Panel("xy_flat", "Separable bilateral", of("xy", *_BILATERAL) + of("xy_flat", "levels")),
    Panel("fbl_flat", "FBL", of("fbl", *_FBL) + of("fbl_flat", "levels")),
)
_STYLES = (
    INPUT,
    Panel("mean_shift", "Mean shift", of("mean_shift", "spatial", "range", "min_region")),
    Panel("bilateral_flat", "Bilateral + quantization", of("bilateral", *_BILATERAL) + of("bilateral_flat", "levels")),
    Panel("fbl_flat", "FBL + quantization", of("fbl", *_FBL) + of("fbl_flat", "levels")),
)

FIGURES: tuple[Figure, ...] = (
    Figure(
        "fig01",
        "Fig. 1: image abstraction",
        (Row("astronaut.jpg", _COMBINED), Row("astronaut.jpg", _COMBINED, (140, 20, 220, 220), columns=4)),
        width=460,
        columns=2,
    ),
    Figure(
        "fig03",
        "Fig. 3: ETF construction",
        (
            Row("chelsea.png", (INPUT, _FLOW)),
            Row("raccoon.jpg", (INPUT, _FLOW), (470, 70, 440, 330)),
            Row("columns.jpg", (INPUT, _FLOW)),
        ),
        width=440,
        columns=2,
    ),
    Figure(
        "fig04",
        "Fig. 4: iterative ETF construction",
        (
            Row(
                "chelsea.png",
                (
                    INPUT,
                    Panel("first", "First iteration", of("flow_1", *_ETF)),
                    Panel("second", "Second iteration", of("flow_2", *_ETF)),
                    Panel("third", "Third iteration", of("flow_3", *_ETF)),
                ),
            ),
        ),
        width=460,
        columns=2,
    ),
    Figure(
        "fig05",
        "Fig. 5: separable ETF construction",
        tuple(
            Row(
                name,
                (
                    INPUT,
                    Panel("full", "Full kernel", of("flow_full", *_ETF)),
                    Panel("separable", "Separable kernel", of("flow_separable", *_ETF)),
                ),
            )
            for name in ("coffee.exr", "chelsea.png")
        ),
        width=330,
        columns=3,
        measure=distance,
    ),
    Figure(
        "fig07",
        "Fig. 7: FDoG and its parameters",
        (
            Row(
                "chelsea.png",
                (
                    INPUT,
                    Panel("dog", "Isotropic DoG", of("dog", *_DOG)),
                    Panel("fdog", "FDoG: sigma_m = {fdog.sigma_m}", of("fdog", *_FDOG)),
                    Panel("sigma_m_1", "FDoG: sigma_m = {sigma_m_1.sigma_m}", of("sigma_m_1", *_FDOG)),
                    Panel("sigma_c_2", "FDoG: sigma_c = {sigma_c_2.sigma_c}", of("sigma_c_2", *_FDOG)),
                    Panel("rho_997", "FDoG: rho = {rho_997.rho}", of("rho_997", *_FDOG)),
                ),
            ),
        ),
        width=330,
        columns=3,
        measure=pieces("dog", "fdog", "sigma_m_1", "sigma_c_2", "rho_997"),
    ),
    Figure(
        "fig08",
        "Fig. 8: lines from isolated points",
        tuple(Row(name, _DOTS) for name in ("circle", "x", "t")),
        columns=5,
        measure=pieces("dog", "fdog", "third"),
    ),
    Figure(
        "fig09",
        "Fig. 9: noise",
        (
            Row(
                "disc",
                (
                    INPUT,
                    Panel("dog_low", "DoG, tau = {dog_low.tau}", of("dog_low", *_DOG)),
                    Panel("dog_high", "DoG, tau = {dog_high.tau}", of("dog_high", *_DOG)),
                    Panel("dog_best", "DoG at its best", of("dog_best", *_DOG)),
                    Panel("lic", "ETF", of("flow", *_ETF, "pre_blur")),
                    Panel("fdog", "FDoG, tau = {fdog.tau}", of("fdog", *_FDOG)),
                ),
            ),
        ),
        width=200,
        columns=3,
        measure=contour("dog_low", "dog_high", "dog_best", "fdog"),
    ),
    Figure(
        "fig10",
        "Fig. 10: small-scale texture",
        (
            Row("texture", _TEXTURE),
            Row("texture", _TEXTURE, (75, 75, 50, 50), 4),
        ),
    ),
    Figure(
        "fig11_13",
        "Figs. 11 to 13: iterative FDoG",
        tuple(Row(name, _FIRST_THIRD) for name in ("astronaut.jpg", "columns.jpg", "chelsea.png")),
        width=270,
        measure=pieces("dog", "first", "third"),
    ),
    Figure(
        "fig14",
        "Fig. 14: line extraction compared",
        (
            Row(
                "astronaut.jpg",
                (
                    INPUT,
                    Panel("canny", "Canny", of("canny", "sigma", "low", "high")),
                    Panel("borders", "Mean shift", of("segments", "spatial", "range", "min_region")),
                    Panel("dog", "Isotropic DoG", of("dog", *_DOG)),
                    Panel("fdog", "FDoG", of("fdog", *_ITERATIVE)),
                ),
            ),
        ),
        width=330,
        columns=3,
    ),
    Figure(
        "fig16",
        "Fig. 16: boundary restoration",
        (
            Row("noisy", (INPUT, _BIL, _FLOW_BIL)),
            Row("noisy", (INPUT, _BIL, _FLOW_BIL), (170, 130, 80, 60), 4),
        ),
        width=320,
        columns=3,
        measure=noise_ratio("plate", "bilateral", "fbl"),
    ),
    Figure(
        "fig17",
        "Fig. 17: shape enhancement",
        (
            Row("blocky", (INPUT, _FLOW, _BIL, _FLOW_BIL)),
            Row("blocky", (INPUT, _BIL, _FLOW_BIL), (140, 80, 100, 75), 3, columns=3),
            Row("blocky", (INPUT, _BIL, _FLOW_BIL), (225, 210, 100, 75), 3, columns=3),
        ),
        width=400,
        columns=2,
        measure=noise_ratio("plate", "bilateral", "fbl"),
    ),
    Figure(
        "fig18",
        "Fig. 18: feature-enhancing stylization",
        (
            Row(
                "chelsea.png",
                (
                    INPUT,
                    _FLOW,
                    _BIL,
                    _FLOW_BIL,
                    Panel("bilateral_flat", "Bilateral filter (flattened)", of("bilateral_flat", "levels")),
                    Panel("fbl_flat", "FBL (flattened)", of("fbl_flat", "levels")),
                ),
            ),
            Row("chelsea.png", (_BIL, _FLOW_BIL), (130, 10, 110, 80), 4),
        ),
        width=451,
        columns=2,
    ),
    Figure(
        "fig19",
        "Fig. 19: texture stylization",
        (Row("blobs", _TEXTURES, (50, 40, 75, 65), 4), Row("grass.png", _TEXTURES, (110, 100, 75, 65), 4)),
    ),
    Figure(
        "fig20",
        "Fig. 20: kernel shapes",
        (
            Row(
                "chelsea.png",
                (
                    INPUT,
                    Panel("circle", "Full kernel: circle", of("circle", *_BILATERAL)),
                    Panel("xy", "xy-separable: axis-aligned line", of("xy", *_BILATERAL)),
                    Panel("line", "Anisotropic: oriented line", of("line", *_FBL)),
                    Panel("arc", "Structure-adaptive: oriented arc", of("arc", *_FBL)),
                    Panel("curve", "FBL: free-form curve", of("curve", *_FBL)),
                ),
                (130, 75, 110, 80),
                3,
            ),
        ),
        width=330,
        columns=3,
    ),
    Figure(
        "fig21",
        "Fig. 21: stylization compared",
        tuple(
            row
            for name, box in (("coffee.exr", (180, 110, 150, 100)), ("chelsea.png", (130, 70, 150, 100)))
            for row in (Row(name, _STYLES), Row(name, _STYLES, box, 2))
        ),
        width=300,
    ),
    Figure(
        "fig24",
        "Fig. 24: results",
        tuple(
            Row(name, (INPUT, panel))
            for name, panel in (
                ("chelsea.png", Panel("comp", "Cat", _ALL)),
                ("columns.jpg", Panel("lines", "Arcade, lines alone", of("lines", *_ITERATIVE))),
                ("coffee.exr", Panel("comp", "Coffee", _ALL)),
                ("bridge.jpg", Panel("flat", "Bridge, colour alone", of("smooth", *_FBL) + of("flat", "levels"))),
                ("astronaut.jpg", Panel("comp", "Astronaut", _ALL)),
            )
        ),
        width=440,
        columns=2,
    ),
    Figure(
        "fig25",
        "Fig. 25: a large picture",
        (
            Row("raccoon.jpg", (INPUT, Panel("comp", "Abstraction", _ALL))),
            Row("raccoon.jpg", (INPUT, Panel("comp", "Abstraction", _ALL)), (430, 60, 460, 320)),
        ),
        width=460,
        columns=2,
    ),
    Figure(
        "xdog",
        "Beyond the paper: XDoG",
        (
            Row(
                "astronaut.jpg",
                (
                    INPUT,
                    Panel("pencil", "Pencil", of("pencil", *_XDOG)),
                    Panel("pastel", "Pastel", of("pastel", *_XDOG)),
                    Panel("comp", "Pastel over the picture"),
                    Panel("ink", "Ink", of("ink", *_XDOG)),
                    Panel("negative", "Negative edges", of("negative", *_XDOG)),
                ),
            ),
        ),
        width=330,
        columns=3,
    ),
)
