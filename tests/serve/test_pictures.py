"""Pictures in requests: what is missing or wrong is told with its place; pixels stay within their memory."""

import mmap

import numpy as np
import pytest

from flowabs_nodes.errors import CommandError, FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.serve.pictures import picture
from flowabs_nodes.serve.shared_memory import SharedMemory
from tests.serve.wire import plate


class NoFile(SharedMemory):
    """Memory without a file that somebody may make shorter."""

    def check(self):
        pass


MEMORY = {3: NoFile(mmap.mmap(-1, 4096), 4096)}
GOOD = {"memory": 3, "width": 4, "height": 2, "channels": "RGBA", "dtype": "float32"}


def parsed(**changes):
    return picture({**GOOD, **changes}, "given.plate", MEMORY, 10_000)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"memory": 4}, "given.plate.memory: no memory 4 is mapped"),
        ({"memory": "3"}, "expected a whole number, found '3'"),
        ({"width": 0}, "given.plate.width: expected 1 to"),
        ({"width": None}, "given.plate.width: expected a whole number, found nothing"),
        ({"height": True}, "expected a whole number, found True"),
        ({"width": 101, "height": 100}, "101x100 is more than 10000 pixels"),
        ({"channels": "BGRA"}, "expected 'RGBA' or 'RGB' or 'A', found 'BGRA'"),
        ({"dtype": "float64"}, "expected 'float32'"),
        ({"row_bytes": 63}, "row_bytes: expected at least 64, found 63"),
        ({"row_bytes": -63}, "row_bytes: expected at least 64, found -63"),
        ({"rows": "up"}, "'bottom-up'"),
        ({"alpha": "none"}, "'premultiplied' or 'straight' or 'opaque'"),
        ({"offset": -4}, "given.plate.offset: expected 0 to"),
        ({"window": [1]}, "given.plate.window: expected 2 whole numbers"),
        ({"window": [1.5, 2]}, "given.plate.window: expected 2 whole numbers"),
        ({"display": [0, 0, 10**12, 4]}, "given.plate.display: expected 4 whole numbers"),
        ({"rowbytes": 64}, "given.plate.rowbytes: no such key (did you mean 'row_bytes'?)"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(changes, said):
    with pytest.raises(CommandError) as raised:
        parsed(**changes)
    assert said in str(raised.value)


@pytest.mark.parametrize("value", [None, [], "RGBA", 3])
def test_a_picture_is_an_object(value):
    with pytest.raises(CommandError, match=r"given.plate: expected an object"):
        picture(value, "given.plate", MEMORY, 10_000)


@pytest.mark.parametrize(
    "changes",
    [
        {"offset": 4096 - 127},
        {"offset": 4096},
        {"row_bytes": 4096 - 63},
        {"row_bytes": -64, "offset": 63},
        {"row_bytes": -64, "offset": 4096 - 63},
        {"width": 16, "height": 17},
        {"row_bytes": 2**40},
    ],
)
def test_pixels_beyond_their_memory_are_refused(changes):
    with pytest.raises(CommandError, match="expected pixels within 4096 bytes"):
        parsed(**changes).view()


@pytest.mark.parametrize("changes", [{"offset": 4096 - 128}, {"row_bytes": -64, "offset": 4096 - 64}])
def test_the_last_byte_of_a_memory_can_be_used(changes):
    view = parsed(**changes).view()
    assert view.shape == (2, 4, 4)
    view[...] = 1


def test_negative_row_bytes_begin_at_the_last_row_unless_said():
    view = parsed(row_bytes=-64).view()
    assert view.strides == (-64, 16, 4)
    view[1] = 5
    assert parsed().view()[0, 0, 0] == 5


@pytest.mark.parametrize(
    ("channels", "types", "kind"),
    [
        ("RGBA", "color", "color"),
        ("RGB", "color", "color"),
        ("A", "color", "matte"),
        ("A", "matte", "matte"),
        ("A", "mono", "mono"),
        ("A", "depth", "depth"),
        ("RGB", "normal", "normal"),
        ("RGBA", "motion", "motion"),
        ("RGBA", "=image", "color"),
        ("A", "=image", "matte"),
    ],
)
def test_an_image_has_the_type_of_its_port_where_its_channels_fit(channels, types, kind):
    assert parsed(channels=channels).image(types).type == kind


def test_eight_bits_of_a_mask_are_a_share_of_one():
    there = parsed(channels="A", dtype="uint8")
    there.view()[...] = 51
    np.testing.assert_array_equal(there.image("matte").pixels, np.full((2, 4, 1), np.float32(51) / np.float32(255)))


def test_opaque_pixels_have_no_alpha():
    there = parsed(alpha="opaque")
    there.view()[...] = 0.5
    image = there.image("color")
    assert image.channels == ("R", "G", "B")
    there.fill(image)
    np.testing.assert_array_equal(there.view()[..., 3], 1)
    np.testing.assert_array_equal(there.view()[..., :3], 0.5)


def test_a_part_of_a_picture_is_delivered_with_nothing_around_it():
    image = Image.from_array(plate(6, 8), data_window=(2, 1, 8, 6), display_window=(0, 0, 12, 9))
    there = parsed(window=[8, 5])
    there.view()[...] = 9
    said, payload = there.fill(image)
    assert payload is None
    assert said["display"] == [0, 0, 12, 9]
    np.testing.assert_array_equal(there.view()[:, :2], image.pixels[4:6, 6:8])
    np.testing.assert_array_equal(there.view()[:, 2:], 0)


def test_a_mattes_one_channel_is_delivered_as_one_and_as_grey():
    image = Image.from_array(plate(2, 4, 1), type="matte")
    one, four = parsed(channels="A"), parsed(offset=1024)
    one.fill(image)
    four.fill(image)
    np.testing.assert_array_equal(one.view(), image.pixels)
    np.testing.assert_array_equal(four.view()[..., :3], np.repeat(image.pixels, 3, axis=2))
    np.testing.assert_array_equal(four.view()[..., 3], 1)


def test_without_a_size_all_of_a_result_is_delivered():
    image = Image.from_array(plate(6, 8), data_window=(2, 1, 8, 6))
    there = picture({"channels": "RGB"}, "into.comp", {}, 10_000, sized=False)
    said, payload = there.fill(image)
    assert (said["width"], said["height"], said["window"], said["memory"]) == (8, 6, [2, 1], None)
    np.testing.assert_array_equal(payload.view(np.float32).reshape(6, 8, 3), image.pixels[..., :3])


def test_channels_that_a_result_has_not_are_an_error():
    flow = Image.from_array(np.zeros((2, 4, 2), np.float32), type="flow")
    with pytest.raises(FlowabsError, match="expected shape"):
        parsed().fill(flow)
