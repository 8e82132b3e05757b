"""OCIO configs: a missing or broken one is an error, what they lack is ours, $OCIO is nobody's business here."""

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import config, named
from flowabs_nodes.errors import ColorError

#: A small studio's config: ACEScg under its own names, a log encoding of it, names that mean something else than usual.
SHOW = """ocio_profile_version: 2
roles: {scene_linear: show_lin, default: bytes, data: bytes, aces_interchange: aces}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  mon:
    - !<View> {name: Raw, colorspace: bytes}
colorspaces:
  - !<ColorSpace> {name: aces}
  - !<ColorSpace> {name: bytes, isdata: true}
  - !<ColorSpace>
    name: show_lin
    aliases: [linear]
    to_scene_reference: !<MatrixTransform> {matrix: [MATRIX]}
  - !<ColorSpace>
    name: show_log
    to_scene_reference: !<GroupTransform>
      children:
        - !<LogTransform> {base: 2, direction: inverse}
        - !<MatrixTransform> {matrix: [MATRIX]}
  - !<ColorSpace>
    name: sRGB
    to_scene_reference: !<ExponentTransform> {value: 1.8}
"""
AP1_TO_AP0 = (
    "0.6954522, 0.1406787, 0.1638691, 0, 0.0447946, 0.8596711, 0.0955343, 0, "
    "-0.0055259, 0.0040252, 1.0015007, 0, 0, 0, 0, 1"
)


@pytest.fixture
def show(tmp_path):
    path = tmp_path / "show.ocio"
    path.write_text(SHOW.replace("MATRIX", AP1_TO_AP0))
    return str(path)


BROKEN = {
    "missing": None,
    "empty": b"",
    "text": b"these are not the colours you are looking for\n",
    "bytes": b"\xff\xfe\x00\x81\x00",
    "truncated": SHOW[:60].encode(),
}


@pytest.fixture(params=[*BROKEN, "folder", "ocio://no-such-config", "ocio://"])
def broken(request, tmp_path):
    if request.param.startswith("ocio:"):
        return request.param
    if request.param == "folder":
        return str(tmp_path)
    path = tmp_path / "é.ocio"
    if BROKEN[request.param] is not None:
        path.write_bytes(BROKEN[request.param])
    return str(path)


def test_a_config_that_cannot_be_read_is_fatal(broken):
    rgb = np.zeros((1, 1, 3), np.float32)
    space = color.space("lin_rec709")
    for use in (
        lambda: config.config(broken),
        lambda: color.space("ACEScg", broken),
        lambda: color.detect(oiio.ImageSpec(1, 1, 3, "half"), ocio=broken),
        lambda: color.ocio.linearize(rgb, "sRGB", broken),
        lambda: color.ocio.encode_named(rgb, space, "lin_rec709", broken),
    ):
        with pytest.raises(ColorError, match="cannot be read") as caught:
            use()
        assert broken in str(caught.value)
        assert caught.value.code == "bad-ocio-config"


def test_the_environment_is_not_asked(monkeypatch, show):
    monkeypatch.setenv("OCIO", "/no/such/config.ocio")
    config._parsed.cache_clear()
    assert config.config().configname() == config.PINNED
    assert color.space("ACES - ACEScg").name == "lin_ap1_scene"
    assert color.ocio.linearize(np.full((1, 1, 3), 0.5, np.float32), "ACEScct")[1].name == "lin_ap1_scene"
    monkeypatch.setenv("OCIO", show)
    with pytest.raises(ColorError):
        color.space("show_lin")


def test_names_mean_what_the_config_says(show):
    ap1, rec709 = color.space("ACEScg"), color.space("lin_rec709")
    assert color.space("show_lin", show) == ap1
    assert color.space("scene_linear", show) == ap1
    assert color.space("linear", show) == ap1
    assert color.space("linear") == rec709
    assert color.space("lin_rec709_scene", show) == rec709  # the same in every config
    assert color.space("lin_p3d65", show).name == "lin_p3d65_scene"  # not there: as everybody means it
    assert named.find("sRGB", show).kind == "encoded"
    assert named.find("srgb_rec709_scene", show).kind == "srgb"
    assert named.find("bytes", show).kind == "data"
    with pytest.raises(ColorError) as caught:
        color.space("show_ling", show)
    assert "'show_lin'" in caught.value.hint
    assert show in str(caught.value)


def test_pixels_through_a_config_of_ones_own(show):
    codes = np.random.default_rng(0).uniform(-3, 1, (4, 5, 3)).astype(np.float32)
    rgb, space = color.ocio.linearize(codes, "show_log", show)
    assert space.name == "lin_ap1_scene"
    np.testing.assert_allclose(rgb, 2.0**codes, rtol=1e-3)
    np.testing.assert_allclose(color.ocio.encode_named(rgb, space, "show_log", show), codes, atol=1e-3)


def test_a_config_that_ties_to_nothing(tmp_path):
    odd = "0.5, 0.3, 0.2, 0, 0.1, 0.8, 0.1, 0, 0.05, 0.05, 0.9, 0, 0, 0, 0, 1"
    text = SHOW.replace("MATRIX", odd).replace(", aces_interchange: aces", "").replace("name: aces}", "name: x}")
    path = tmp_path / "alone.ocio"
    path.write_text(text)
    with pytest.raises(ColorError, match="no interchange role"):
        color.space("show_lin", str(path))
    assert color.space("ACES2065-1", str(path)).name == "lin_ap0_scene"


def test_messages_that_are_no_text():
    def geterror():
        raise UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid start byte")

    assert "not UTF-8" in config.said(geterror)


def test_an_impossible_conversion_names_both_ends():
    with pytest.raises(ColorError, match=r"'nowhere'.*'ACEScg'"):
        config.convert(np.zeros((1, 1, 3), np.float32), "nowhere", "ACEScg")
