"""Images travel to other processes as plain data, and say so where they come from another version."""

import copy
import multiprocessing
import pickle

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import color
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Origin
from flowabs_nodes.image import state as image_state
from tests.engine.fakes import picture

ATTRIBUTES = {
    "int": ("int", -5),
    "ints": ("int[3]", (1, 2, 3)),
    "large": ("uint", 4_000_000_000),
    "float": ("float", 0.1),
    "one": ("float[1]", (1.5,)),
    "text": ("string", 'Übersicht <&> "quoted"'),
    "texts": ("string[3]", ("a", "", "c, d")),
    "byte": ("uint8", 200),
    "ICCProfile": ("uint8[20]", bytes(range(20))),
    "worldToCamera": ("matrix", tuple(x / 7 for x in range(16))),
    "matrices": ("matrix[2]", tuple(map(float, range(32)))),
    "colour": ("color", (1.0, 2.0, 3.0)),
    "normal": ("normal", (1.0, 0.0, 0.0)),
    "smpte:TimeCode": ("timecode", (0x01020304, 5)),
    "smpte:KeyCode": ("keycode", (1, 2, 3, 4, 5, 6, 7)),
    "FramesPerSecond": ("rational", (24000, 1001)),
    "box": ("box2i", (0, 1, 2, 3)),
}


def attributes(image):
    return {each.name: (str(each.type), repr(each.value)) for each in image.spec.extra_attribs}


def plate():
    """Return an image with everything that an image can have."""
    spec = picture(alpha=True).spec
    for name, (kind, value) in ATTRIBUTES.items():
        spec.attribute(name, oiio.TypeDesc(kind), value)
    spec.channelformats = tuple(map(oiio.TypeDesc, ("half", "float", "half", "uint")))
    spec.set_format(oiio.HALF)
    spec.channelformats = tuple(map(oiio.TypeDesc, ("half", "float", "half", "uint")))
    spec.tile_width, spec.tile_height, spec.full_depth = 64, 32, 1
    origin = Origin("plate.exr", 1, "diffuse", ("diffuse.R",), "A")
    return Image(picture(alpha=True).pixels, spec, "color", colorspace="lin_ap1_scene", origin=origin)


def same(found, expected):
    """Hold one image to another in all that an image has."""
    np.testing.assert_array_equal(found.pixels, expected.pixels)
    assert (found.type, found.origin, found.colorspace) == (expected.type, expected.origin, expected.colorspace)
    assert attributes(found) == attributes(expected)
    for name in [each for each in dir(oiio.ImageSpec) if not each.startswith("_")]:
        mine, theirs = getattr(found.spec, name), getattr(expected.spec, name)
        assert name == "extra_attribs" or callable(theirs) or str(mine) == str(theirs), name
    return True


@pytest.mark.parametrize("travel", [lambda image: pickle.loads(pickle.dumps(image)), copy.deepcopy, copy.copy])
def test_nothing_is_lost_on_the_way(travel):
    image = plate()
    assert set(ATTRIBUTES) <= set(attributes(image))
    found = travel(image)
    assert same(found, image)
    assert not found.pixels.flags.writeable


def test_a_deep_copy_shares_nothing():
    image = plate()
    assert not np.shares_memory(copy.deepcopy(image).pixels, image.pixels)


@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_every_protocol_carries_every_type(protocol):
    for image in (
        picture(),
        Image.from_array(np.ones((2, 3)), type="matte"),
        Image.from_array(np.ones((2, 3, 2))),
        Image.from_array(np.ones((2, 3, 5)), type="data", channels=tuple("abcde")),
    ):
        assert same(pickle.loads(pickle.dumps(image, protocol)), image)


def test_the_array_can_stay_where_it_is():
    """Out of band, as dask sends it: the memory that arrives cannot be written to."""
    image, buffers = plate(), []
    data = pickle.dumps(image, 5, buffer_callback=buffers.append)
    found = pickle.loads(data, buffers=[bytes(each) for each in buffers])
    assert same(found, image)
    np.testing.assert_array_equal(found.encoded(), image.encoded())


@pytest.mark.parametrize(
    "name", ["lin_rec709", "chromaticities(0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.31, 0.33)", "Linear ARRI Wide Gamut 3"]
)
def test_colour_spaces_come_back_by_value(name):
    image = Image(picture().pixels, picture().spec, "color", colorspace=color.space(name))
    assert pickle.loads(pickle.dumps(image)).colorspace == image.colorspace


def test_code_values_travel_as_pixels():
    image = picture().with_codes(picture().encoded() * np.float32(0.9), "lab")
    found = pickle.loads(pickle.dumps(image))
    assert found.deferred is None
    np.testing.assert_array_equal(found.pixels, image.pixels)


def test_doubles_keep_their_digits():
    spec = picture().spec
    spec.from_xml('<ImageSpec version="27"><attrib name="a &amp; b" type="double">0.1</attrib></ImageSpec>')
    image = Image(picture().pixels, with_windows(spec), "color")
    assert attributes(image)["a & b"] == ("double", "0.1")
    assert attributes(pickle.loads(pickle.dumps(image))) == attributes(image)


def with_windows(spec):
    """Return a header that fits ``picture()``."""
    spec.width, spec.height, spec.nchannels, spec.channelnames = 8, 6, 3, ("R", "G", "B")
    return spec


def exposed(image):
    """Do a little work, in another process."""
    return image.with_pixels(image.pixels * np.float32(2))


def test_images_go_to_processes_that_are_spawned_and_back():
    image = plate()
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        found = pool.apply(exposed, (image,))
    assert same(found, image.with_pixels(image.pixels * np.float32(2)))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": 2, "flowabs": "9.1.0"}, r"flowabs 9\.1\.0 pickled .* expected format 1, found 2"),
        ({"format": None}, "found None"),
    ],
)
def test_an_image_of_another_version_is_refused_in_words(monkeypatch, change, words):
    packed = image_state.packed
    monkeypatch.setattr(image_state, "packed", lambda *args: packed(*args) | change)
    data = pickle.dumps(picture())
    with pytest.raises(FlowabsError, match=words) as failure:
        pickle.loads(data)
    assert failure.value.code == "other-version"
    assert "same version of flowabs on both sides" in failure.value.hint


@pytest.mark.parametrize("state", [{}, None, (None, {"pixels": 1}), [1, 2]])
def test_whatever_else_was_pickled_under_this_name_is_refused_too(state):
    with pytest.raises(FlowabsError, match="flowabs another version pickled"):
        Image.__new__(Image).__setstate__(state)
