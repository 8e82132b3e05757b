import numpy as np

from flowabs_nodes.filters.background import FAR
from flowabs_nodes.looking.depth import look_at_depth
from tests.looking.images import image


def test_near_is_white_far_dark_and_the_background_black():
    look = look_at_depth(image([[2, 6, 10, FAR, np.inf, np.nan]], "depth"))
    near, middle, far, *background = look.codes[0, :, 0]
    assert near == 1
    np.testing.assert_allclose([middle, far], [0.55, 0.1], atol=1e-6)
    assert background == [0, 0, 0]
    assert look.said == "depth from 2.08 (white) to 9.92 (dark grey), its 1st and 99th percentile; background black"


def test_without_background_none_is_said():
    assert "background" not in look_at_depth(image([[2, 6]], "depth")).said


def test_nothing_but_background():
    look = look_at_depth(image([[FAR, FAR]], "depth"))
    assert not look.codes.any()
    assert "nothing but background" in look.said
