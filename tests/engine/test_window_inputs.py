import numpy as np
import pytest

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Port
from tests.engine.fakes import picture
from tests.engine.windows import MEAN, asking, grey

CONTEXT = Context(frame=7, node="mean")


def of_one_shot(image):
    """Return the image on the display window of :func:`picture`."""
    spec = image.spec
    spec.full_width, spec.full_height = 32, 24
    return Image(image.pixels, spec, image.type)


def seen(inputs, **params):
    """Return what the node's function gets as its image."""
    found = {}

    def run(context, image, *, radius):
        found.update(image)
        return image[0]

    call_node(asking(MEAN.frames, run), CONTEXT, inputs, params)
    return found


def test_a_node_gets_a_dict_from_offset_to_image_in_order():
    images = {1: grey(1), -1: grey(-1), 0: grey(0)}
    found = seen({"image": images}, radius=1)
    assert list(found) == [-1, 0, 1]
    assert all(found[offset] is images[offset] for offset in images)


def test_one_image_is_the_own_frame():
    image = grey(3)
    assert seen({"image": image}) == {0: image}


def test_other_frames_are_cut_to_the_own_frames_data_window_and_0_outside():
    own, other = picture(), of_one_shot(grey(1, 5, 5))  # on windows 8x6+3-2 and 5x5+0+0
    found = seen({"image": {0: own, 1: other}})
    assert found[1].data_window == own.data_window
    assert found[1].pixels.sum() == 3 * 2 * 4
    assert found[1].pixels[2:6, 0:2].min() == 1


def test_a_frame_of_another_size_is_refused():
    words = "frame 8 of input 'image' is of a picture of 5x5, but frame 7 of 32x24"
    with pytest.raises(FlowabsError, match=words) as failure:
        seen({"image": {0: picture(), 1: grey(1, 5, 5)}})
    assert failure.value.code == "window-mismatch"


def test_other_frames_are_of_the_own_frames_type():
    matte = Image.from_array(np.ones((4, 6)), type="matte")
    color = Node(
        "mean", 1, ".", (Port("image", "color", "."),), MEAN.outputs, MEAN.params, MEAN.run, frames=MEAN.frames
    )
    out = call_node(color, CONTEXT, {"image": {0: matte, 1: matte}}, {})
    assert out["image"].type == "color"


def test_mask_and_mix_go_over_the_own_frame():
    images = {-1: grey(0), 0: grey(1), 1: grey(5)}
    assert call_node(MEAN, CONTEXT, {"image": images}, {})["image"].pixels.max() == 2
    assert call_node(MEAN, CONTEXT, {"image": images}, {"mix": 0.5})["image"].pixels.max() == 1.5
    mask = Image.from_array(np.eye(4, 6), type="matte")
    masked = call_node(MEAN, CONTEXT, {"image": images, "mask": mask}, {})["image"].pixels
    assert np.array_equal(masked[..., 0], 1 + np.eye(4, 6))


def test_windows_and_metadata_of_the_own_frame_stay():
    own = picture()
    out = call_node(MEAN, CONTEXT, {"image": {0: own, 1: of_one_shot(grey(1, 6, 8))}}, {})["image"]
    assert (out.data_window, out.display_window) == (own.data_window, own.display_window)
    assert out.spec.getattribute("owner") == "somebody"


@pytest.mark.parametrize(
    ("declaration", "image", "words"),
    [
        (MEAN, {-1: grey(1), 1: grey(1)}, "input 'image' needs the node's own frame, 0, .*found -1, 1"),
        (MEAN, {}, "found none"),
        (asking({"image": (0, 1000)}), grey(1), "at most 64"),
    ],
)
def test_errors_name_node_and_frame(declaration, image, words):
    with pytest.raises(FlowabsError, match=words) as failure:
        call_node(declaration, CONTEXT, {"image": image}, {})
    assert (failure.value.node, failure.value.frame) == ("mean", 7)


def test_what_frames_raises_is_told_like_any_fault_of_a_node():
    with pytest.raises(FlowabsError, match="ZeroDivisionError") as failure:
        call_node(asking(lambda params: 1 / 0), CONTEXT, {"image": grey(1)}, {})
    assert (failure.value.code, failure.value.node) == ("internal", "mean")
