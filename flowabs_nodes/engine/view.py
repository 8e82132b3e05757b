"""Looks at one node of a graph on one frame, for ``flowabs run --view``; nothing that the graph writes is made."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from functools import partial

from flowabs_nodes.engine.job_builder import (
    as_command_errors,
    as_list,
    check_format,
    frames_asked_for,
    set_files,
)
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.plan import file_role, make_plan, named_result
from flowabs_nodes.engine.report import Listener
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.engine.runnable import GraphSource, RunnableGraph, load_graph
from flowabs_nodes.engine.sources import file_of, reads_pictures
from flowabs_nodes.engine.target_files import check_folders, refuse_inputs
from flowabs_nodes.engine.unit_params import UnitParams, inputs_on_any_frame
from flowabs_nodes.errors import CommandError, WriteError
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.image import Image
from flowabs_nodes.io import formats
from flowabs_nodes.io.sequences import Sequence
from flowabs_nodes.io.settings import checked
from flowabs_nodes.io.write import build_picture, save, stored_key

#: The key in a picture's file: no run takes it for a frame of its own, and another view may replace it.
_KEY = "a view"

#: The formats of pictures that are made to be looked at.
_FORMATS = tuple(each for each in formats.WRITABLE if each.display_referred)


@dataclass(frozen=True)
class View:
    """What to look at, where nothing can go wrong any more but the computation.

    Attributes
    ----------
    graph
        The graph, with everything set that is set.
    output
        The output to look at: "node" or "node.output".
    frame
        The frame to look at.
    file
        The file that the picture goes to; "" where it is only shown.
    options
        The options of the run.
    """

    graph: RunnableGraph
    output: str
    frame: int
    file: str
    options: RunOptions

    def picture(self, on_event: Listener | None = None) -> Image:
        """Compute the picture, and tell how it shows the image's numbers; errors are those of ``graph.run``."""
        return self.graph.view(
            self.output,
            frame=self.frame,
            scale=self.options.scale,
            settings=self.options.settings,
            on_event=on_event,
        )

    def save(self, picture: Image) -> None:
        """Write the picture to ``file``, whole or not at all. Raises WriteError."""
        written = build_picture(picture, settings=self.options.settings)
        save(written, self.file, key=f"{_KEY} {self.output}", graph=json.dumps(self.graph.document))


def build_view(graph: GraphSource, output: str, options: RunOptions) -> View:
    """Return the view of an output of a graph, on the first frame that ``options`` ask for.

    ``options.output`` names the picture, a PNG or TIFF; ``options.existing`` as for a run, but what a view has written
    is always made again.

    Raises
    ------
    GraphError, CommandError, ColorError
        The graph or an option is wrong, a name does not exist, or the file is in the way; nothing has been written.
    """
    options, _ = choose_config(options)
    settings = options.settings
    loaded = load_graph(graph)
    if options.set:
        loaded = loaded.with_set(options.set)
    targets = as_list(options.output)
    asked, _ = set_files(loaded, replace(options, output=None))
    result = named_result(asked, output, 1)
    reads = _reads(asked, output)
    values = asked.values(1)
    with as_command_errors():
        inputs = {name: Sequence.to_read(file_of(asked, name, values[name])) for name in reads}
        for name, sequence in inputs.items():
            checked(sequence.pattern, settings)
            if reads_pictures(asked, name):
                check_format(sequence)
        frame = frames_asked_for(options.frames, list(inputs.values()))[0]
        file = _file(targets, frame, options, list(inputs.values()), asked.source)
    runnable = load_graph(asked)
    if options.missing is not None:
        policies = [name for name in reads if "missing" in asked.nodes[name].declaration.all_params]
        runnable = runnable.with_set({f"{name}.missing": options.missing for name in policies})
    return View(runnable, f"{result.node}.{result.output}", frame, file, options)


def _reads(graph: Graph, output: str) -> list[str]:
    """Return the nodes that read a file for an output."""
    needs = partial(inputs_on_any_frame, graph, params=UnitParams(graph))
    steps = make_plan(graph, 1, results=[named_result(graph, output, 1)], inputs_of=needs)
    return [step.unit.node for step in steps if file_role(graph, step.unit.node) == "input"]


def _file(targets: list[str], frame: int, options: RunOptions, inputs: list[Sequence], source: str) -> str:
    """Return the file that a view goes to, "" where there is none; raise CommandError where it must not be written.

    ``source`` is the file of the graph.
    """
    if not targets:
        return ""
    if len(targets) > 1:
        raise CommandError(f"-o: a view is one picture, found {len(targets)} names", code="several-outputs")
    path = Sequence(targets[0]).path(frame)
    if formats.by_extension(path) not in _FORMATS:
        hint = "without --view, an EXR holds the numbers themselves" if path.lower().endswith(".exr") else ""
        raise CommandError(f"a view is a {formats.listed(_FORMATS)}", code="bad-format", hint=hint, file=path)
    checked(path, options.settings)
    refuse_inputs([path], inputs, (frame,), others=(source, options.ocio or ""))
    check_folders([path])
    _refuse_existing(path, options.existing)
    return path


def _refuse_existing(path: str, existing: str) -> None:
    """Raise CommandError for a file that is not to be replaced: nothing but a view is, without being asked."""
    if existing == "overwrite" or not os.path.lexists(path):
        return
    key = stored_key(path)
    if existing == "error" or key is None or not key.startswith(_KEY):
        what = "exists already" if existing == "error" else "exists already, and is no view that flowabs wrote"
        raise WriteError(what, code="exists", hint="--existing overwrite replaces it", file=path)


def as_png(picture: Image, longest: int) -> bytes:
    """Return a PNG of a view's picture, for a terminal; a picture whose longer side is above ``longest`` is reduced."""
    window = picture.display_window
    picture = scale_image(picture, min(1.0, longest / max(window.width, window.height)))
    png = next(each for each in formats.WRITABLE if each.name == "PNG")
    encoder: formats.Encoder = formats.load(png.encoder)
    return encoder(build_picture(picture), png, {}, lambda text: None)
