"""What there is to be named, as data."""

from flowabs_nodes.color.listing import described, explained, listing
from tests.studio import STUDIO, studio


def test_names_that_a_config_has_itself_are_not_listed_as_ours(tmp_path):
    own = STUDIO.replace("aliases: [plate_lin]", "aliases: [plate_lin, linear, ACEScg]")
    found = {each["name"]: each["aliases"] for each in listing(studio(tmp_path, text=own))["flowabs"]}
    assert "linear" not in found["lin_rec709"]
    assert "ACEScg" not in found["lin_ap1_scene"]
    assert "lin_rec709_scene" in found["lin_rec709"]
    assert found["srgb - display"][0] == "srgb - texture"  # "sRGB" itself is the config's


def test_a_space_without_a_way_to_ours_is_listed_too(tmp_path):
    path = studio(tmp_path, interchange="", gain=None)
    assert [each["name"] for each in listing(path)["spaces"]][:3] == ["house_reference", "bytes", "show_lin"]
    assert described("show_log", path)["encoding"] == "log"
    assert explained("lin_rec709", path)["config"] is None
