"""Runs a graph from Python, images in and images out, without writing any file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from flowabs_nodes import graph as graphs
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.frame_numbers import frame_number
from flowabs_nodes.engine.frame_outputs import FrameOutputs
from flowabs_nodes.engine.given import Given, given_images
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.plan import output_names
from flowabs_nodes.engine.plate_file import with_plate_file
from flowabs_nodes.engine.report import Listener, Note, tell_notes
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.image import Image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.signals import interruptible

#: A path, the name of a graph that comes with the package, its content as a dict, or one that is loaded.
GraphSource = str | Path | Mapping[str, Any] | Graph


class RunnableGraph(Graph):
    """Holds a valid graph, which nothing changes, and runs it on pictures in memory as often as is asked: :meth:`run`.

    :func:`load_graph` makes one, :meth:`with_set` one with other values. ``interface`` has the knobs by name, ``nodes``
    the nodes; :class:`~flowabs_nodes.graph.model.Graph` says what else there is.
    """

    def run(
        self,
        frame: int = 1,
        given: Given | None = None,
        set: Mapping[str, Any] | None = None,
        outputs: str | Iterable[str] | None = None,
        scale: float = 1.0,
        settings: Settings | None = None,
        on_event: Listener | None = None,
    ) -> dict[str, Image]:
        """Compute images of one frame.

        Parameters
        ----------
        frame
            The frame's number, for curves and for files of sequences: a whole number of Python or NumPy.
        given
            Images that stand in for outputs, by ``"node"`` (its first output) or ``"node.output"``. Whatever only
            these outputs depend on, files included, is not touched. An image is that of ``frame``; for nodes that read
            other frames too, give a dict from frame number to Image: ``{"plate": {9: before, 10: image, 11: after}}``
            for frame 10. On frames that are not given, the output is not there.
            An array stands for an Image: floats of scene-linear light, (H, W, 3) or premultiplied (H, W, 4), a matte
            (H, W), or whatever the output's type is; and so does an OpenImageIO ImageBuf.
        set
            Values of knobs and parameters: ``{"line_width": 1.5, "lines.softness": 2}``. NumPy's numbers are numbers.
        outputs
            The outputs to compute, named as in ``given``; one may stand alone: ``"comp"``.
            Without them, all that go into the graph's ``write`` nodes.
        scale
            Above 0 up to 1: makes the pictures that come in smaller, and pixel lengths with them.
        settings
            How pictures are read: the largest size, the OCIO config (without one, what ``$OCIO`` says now, else the
            built-in one), the folder that may be touched.
        on_event
            Called with a dict for each note and warning; without it they go to the logger "flowabs".

        Returns
        -------
        dict
            An Image for each name in ``outputs``. Nothing is written.

        Raises
        ------
        GraphError
            Values in ``set`` are wrong, or a node that is to run needs a package that is not installed.
        CommandError
            A name does not exist (the nearest is told), or a file to read is not set and its image not given.
        ColorError
            The OCIO config is missing, unreadable or broken.
        ArgumentError
            ``frame`` is no whole number, ``scale`` is out of range, or something given is no image of the output's
            type: an array of 8 or 16 bits among them, whose light nobody can tell.
        FlowabsError
            Whatever went wrong while computing, with node and frame.
        KeyboardInterrupt
            Ctrl-C: a second one does not wait until the kernel at work has ended.
        """
        frame = frame_number(frame)
        graph = with_plate_file(self if set is None else self.with_set(set))
        options, about_colors = choose_config(RunOptions(scale=scale, **vars(settings or Settings())))
        stand_ins = {} if given is None else given_images(graph, given, frame)
        images = {result: scale_image(image, options.scale) for result, image in stand_ins.items()}
        names = output_names(graph, outputs)
        notes = list(about_colors)
        try:
            with interruptible():
                return FrameOutputs(graph, frame, names, images, options).compute(notes)
        finally:
            tell_notes(notes, frame, on_event)

    def view(
        self,
        output: str,
        frame: int = 1,
        given: Given | None = None,
        set: Mapping[str, Any] | None = None,
        scale: float = 1.0,
        settings: Settings | None = None,
        on_event: Listener | None = None,
    ) -> Image:
        """Compute a picture of one output, of any type, to look at.

        Colour is seen through the default view of the OCIO config, a flow as colour with its streamlines, numbers of
        any range from dark to bright; a note says how. ``output`` is "node" or "node.output"; the other parameters and
        the errors are those of :meth:`run`.

        Returns
        -------
        Image
            A color image of R, G, B: the light of a screen that shows the picture, white 1. Encoded as sRGB, as
            notebooks and PNG files do, it is what the screen is sent.
        """
        from flowabs_nodes.looking.picture import picture_of  # filters, which other runs may not need

        settings = choose_config(RunOptions(**vars(settings or Settings())))[0].settings
        image = self.run(frame, given, set, output, scale, settings, on_event)[output]
        node = output.partition(".")[0]
        with error_boundary(node, frame):
            picture, said = picture_of(image, settings.ocio)
        tell_notes([Note(said, node)], frame, on_event)
        return picture

    def with_set(self, values: Mapping[str, Any]) -> RunnableGraph:
        """Return the graph with other values of knobs and parameters.

        Raises
        ------
        GraphError
            With every wrong name and value in ``problems``.
        ArgumentError
            ``values`` is no dict.
        """
        return _runnable(graphs.override(self, values))


def load_graph(source: GraphSource) -> RunnableGraph:
    """Load a graph from a file, by the name of one that comes with the package, or from its content as a dict.

    Raises
    ------
    GraphError
        With every problem of the graph in ``problems``.
    CommandError
        If the file cannot be read, or there is no graph of that name.
    ArgumentError
        If ``source`` is something else.
    """
    return _runnable(source if isinstance(source, Graph) else graphs.load(source))


def _runnable(graph: Graph) -> RunnableGraph:
    """Return the same graph with :meth:`RunnableGraph.run`."""
    if isinstance(graph, RunnableGraph):
        return graph
    return RunnableGraph(**{field.name: getattr(graph, field.name) for field in fields(graph)})
