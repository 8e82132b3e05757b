"""OpenImageIO's threads are limited inside, and what they were before afterwards, errors or not."""

from __future__ import annotations

import OpenImageIO as oiio
import pytest

from flowabs_nodes.io.oiio_threads import limited_oiio


def threads() -> tuple[int, int]:
    """Return what OpenImageIO says of its threads."""
    return oiio.get_int_attribute("threads"), oiio.get_int_attribute("exr_threads")


def test_inside_there_are_so_many_threads() -> None:
    before = threads()
    with limited_oiio(3):
        assert threads() == (3, 3)
        with limited_oiio(1):
            assert threads() == (1, 1)
        assert threads() == (3, 3)
    assert threads() == before


def test_after_an_error_there_are_as_many_as_before() -> None:
    before = threads()
    with pytest.raises(RuntimeError, match="disk"), limited_oiio(5):
        raise RuntimeError("disk")
    assert threads() == before
