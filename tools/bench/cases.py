"""The cases to measure: each stage on its own, and whole pipelines as users run them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from flowabs_nodes import color, filters
from flowabs_nodes.errors import CommandError, nearest
from tools.bench.timing import Case

if TYPE_CHECKING:
    from flowabs_nodes.image import Image
    from tools.bench.scene import Array
    from tools.bench.shot import Shot

# The paper's pipeline with its defaults, which are those of the nodes.
P = {
    "format": "flowabs.graph/1",
    "name": "P",
    "nodes": {
        "plate": {"type": "read@1"},
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
        "lines": {"type": "fdog@1", "inputs": {"image": "plate", "flow": "flow"}},
        "smooth": {"type": "fbl@1", "inputs": {"image": "plate", "flow": "flow"}},
        "flat": {"type": "quantize@1", "inputs": {"image": "smooth"}},
        "comp": {"type": "composite@1", "inputs": {"image": "flat", "lines": "lines"}},
        "out": {"type": "write@1", "inputs": {"image": "comp"}},
    },
}


class Plate:
    """A picture and the results of earlier stages on it, each computed on first use.

    ``corner_of`` is the width and height of the picture that it is the upper left corner of, where it is one: graphs
    scale their lengths to that.
    """

    def __init__(self, rgb: Array, corner_of: tuple[int, int] | None = None) -> None:
        self.rgb = rgb
        self.corner_of = corner_of

    @cached_property
    def codes(self) -> Array:
        return color.encode(self.rgb, "lab")

    @cached_property
    def acescct(self) -> Array:
        return color.encode(self.rgb, "acescct")

    @cached_property
    def opponent(self) -> Array:
        return self.image().encoded_opponent("acescct")

    @cached_property
    def code(self) -> Array:
        return self.codes[..., 0].copy()

    @cached_property
    def lstar(self) -> Array:
        return self.code / self.code.dtype.type(2.55)

    @cached_property
    def gradient(self) -> tuple[Array, Array]:
        from flowabs_nodes.filters.flow.gradient import gradient

        return gradient(self.code)

    @cached_property
    def flow(self) -> Array:
        return filters.etf(self.code)

    @cached_property
    def response(self) -> Array:
        return filters.fdog(self.code, self.flow)

    @cached_property
    def lines(self) -> Array:
        return filters.threshold(self.response)

    @cached_property
    def shot(self) -> Shot:
        """Return passes of a shot of the picture's size, and frames around it."""
        from tools.bench.shot import Shot

        return Shot(self.rgb)

    @cached_property
    def bytes(self) -> Any:
        """Return the picture display-referred, 8 bits a channel, as OpenCV's filters take it."""
        import numpy as np

        return np.rint(255 * np.clip(self.rgb, 0, 1) ** (1 / 2.2)).astype(np.uint8)

    def image(self) -> Image:
        """Return the picture as a graph gets it, with no code values computed yet."""
        from flowabs_nodes.image import Image

        image = Image.from_array(self.rgb)
        if self.corner_of is None:
            return image
        spec = image.spec
        spec.full_width, spec.full_height = self.corner_of
        return Image(image.pixels, spec, image.type, colorspace=image.colorspace)


@dataclass(frozen=True)
class Stage:
    """How to run a stage on a plate, and how often the pipeline P runs it."""

    case: Callable[[Plate], Case]
    in_p: int = 0


def _plain(run: Callable[[Plate], object], in_p: int = 0, per: int = 1) -> Stage:
    return Stage(lambda plate: Case(lambda _: run(plate), per=per), in_p)


def _etf(kernel: str, in_p: int = 0) -> Stage:
    """Return the case of one iteration of etf: a third of three iterations' time less the time of none."""
    return Stage(
        lambda plate: Case(
            run=lambda _: filters.etf(plate.code, kernel=kernel, iterations=3),
            less=lambda _: filters.etf(plate.code, kernel=kernel, iterations=0),
            per=3,
        ),
        in_p,
    )


def _gradient(plate: Plate) -> object:
    from flowabs_nodes.filters.flow.gradient import gradient

    return gradient(plate.code)


def _fill(plate: Plate) -> object:
    from flowabs_nodes.filters.flow.fill import flow_fill

    return flow_fill(*plate.gradient, 0.0)


def _finish(plate: Plate) -> object:
    from flowabs_nodes.color.codes import Codes
    from flowabs_nodes.finishing.finish import finish
    from flowabs_nodes.finishing.operations import Ink, Quantize

    operations = Quantize(8, 0.0), Ink(plate.lines, (0.0, 0.0, 0.0), 1.0)
    return finish(Codes(plate.codes, "lab"), operations, color.space("lin_rec709"))


#: How the graph ``abstraction`` draws at 1080 lines.
ABSTRACTION: dict[str, Any] = {
    "sigma_m": 6.0,
    "sigma_c": 2.0,
    "rho": 1.0,
    "color_weight": 1.55,
    "color_sign": True,
    "contrast": 0.3,
    "softness": 2.4,
    "iterations": 2,
    "pre_blur": 3.4,
    "evidence": 1.0,
    "soft_lines": 0.8,
    "soft_reach": 14.0,
    "thin_lines": 8.0,
    "working_scale": "auto",
}


STAGES: dict[str, Stage] = {
    "encode-lab": _plain(lambda p: color.encode(p.rgb, "lab"), in_p=1),
    "encode-acescct": _plain(lambda p: color.encode(p.rgb, "acescct")),
    "gradient": _plain(_gradient, in_p=1),
    "fill": _plain(_fill, in_p=1),
    "etf-full": _etf("full", in_p=3),
    "etf-separable": _etf("separable"),
    "fdog": _plain(lambda p: filters.fdog(p.code, p.flow), in_p=1),
    "fdog-nearest": _plain(lambda p: filters.fdog(p.code, p.flow, sampling="nearest")),
    "fdog-color": _plain(lambda p: filters.fdog(p.codes, p.flow, color_weight=0.5)),
    "fdog-iterative": _plain(lambda p: filters.fdog_iterative(p.opponent, p.flow, **ABSTRACTION)),
    "threshold": _plain(lambda p: filters.threshold(p.response), in_p=1),
    "flow-blur": _plain(lambda p: filters.flow_blur(p.lines, p.flow)),
    "stroke": _plain(lambda p: filters.stroke(p.lines, p.flow, 20, 12)),
    "fbl-nearest": _plain(lambda p: filters.fbl(p.codes, p.flow), in_p=5, per=5),
    "fbl-bilinear": _plain(lambda p: filters.fbl(p.codes, p.flow, iterations=2, sampling="bilinear"), per=2),
    "finish": _plain(_finish, in_p=1),  # quantize, composite and decode-lab in one go
    "quantize": _plain(lambda p: filters.quantize(p.lstar)),
    "quantize-gradient": _plain(lambda p: filters.quantize(p.lstar, by_gradient=1.0)),
    "composite": _plain(lambda p: filters.composite(p.rgb, p.lines)),
    "decode-lab": _plain(lambda p: color.decode(p.codes, "lab")),
    "decode-acescct": _plain(lambda p: color.decode(p.acescct, "acescct")),
    "rolling-guidance": _plain(lambda p: filters.rolling_guidance(p.codes, 4.0, iterations=2)),
    "bilateral-full": _plain(lambda p: filters.bilateral(p.codes, iterations=1)),
    "bilateral-xy": _plain(lambda p: filters.bilateral(p.codes, iterations=1, kernel="xy")),
    "aov-lines": _plain(lambda p: filters.aov_lines(**p.shot.passes)),
    "aov-lines-alone": _plain(lambda p: filters.aov_lines(**p.shot.passes, outputs=("lines",))),
    "ink-lines": _plain(lambda p: filters.ink_lines(p.shot.edges.distance, p.shot.mattes)),
    "join-lines": _plain(lambda p: filters.join_lines(p.shot.edges.lines, p.lines)),
    "boil": _plain(lambda p: filters.boil(p.shot.edges.lines, p.shot.edges.flow, 2.0)),
    "id-matte": _plain(lambda p: filters.id_matte(p.shot.passes["id"], (1, 2, 3))),
    "motion-window": _plain(lambda p: filters.motion_window(**p.shot.window)),
    "motion-window-guide": _plain(lambda p: filters.motion_window(**p.shot.window_of("images", "motions", "guides"))),
}


def graph_case(name: str, plate: Plate) -> Case:
    """Return the case of a pipeline from the plate in memory to the finished picture in memory, decoded."""
    from flowabs_nodes.engine.runnable import load_graph

    graph = load_graph(P if name == "P" else name)

    def run(image: Image) -> Array:
        return graph.run(given={"plate": image}, outputs=["comp"], on_event=lambda event: None)["comp"].pixels

    return Case(run, fresh=plate.image)


PIPELINES: dict[str, Callable[[Plate], Case]] = {
    "P": lambda plate: graph_case("P", plate),
    "abstraction": lambda plate: graph_case("abstraction", plate),
}


def chosen(names: Iterable[str], known: Iterable[str]) -> tuple[str, ...]:
    """Return the names asked for, or all names if none is.

    Raises
    ------
    CommandError
        For a name that does not exist, with the nearest.
    """
    known = tuple(known)
    asked = tuple(dict.fromkeys(names))
    for name in asked:
        if name not in known:
            raise CommandError(f"no stage {name!r} to measure", hint=nearest(name, known), code="unknown-stage")
    return asked or known
