"""The node id_matte: objects by name, from a file with a manifest and without one."""

import numpy as np
import pytest

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.io.manifest import cryptomatte_id
from flowabs_nodes.io.read_id import read_id
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.id_matte import ID_MATTE
from tests.filters.pictures import DATA
from tests.io.files import exr
from tests.io.test_cryptomatte import layer, level

BALL, CRATE = cryptomatte_id("ball"), cryptomatte_id("crate")
ROW = level((BALL, 1.0, 0, 0.0), (BALL, 0.6, CRATE, 0.4), (CRATE, 1.0, 0, 0.0), (CRATE, 0.25, 0, 0.0))


def matte(file, names, context=None):
    ids, coverage = read_id(file)
    inputs = {"id": ids, "coverage": coverage}
    result = call_node(ID_MATTE, context or Context(), inputs, {"names": names})["matte"]
    assert result.type == "matte"
    return result.pixels[0, :, 0]


def written(folder, manifest=""):
    attributes = {"cryptomatte/1234567/name": "CryptoObject"}
    if manifest:
        attributes["cryptomatte/1234567/manifest"] = manifest
    return exr(folder / "ids.exr", layer("CryptoObject00", ROW), **attributes)


def test_objects_by_the_names_in_the_manifest(tmp_path):
    file = written(tmp_path, f'{{"ball":"{BALL:08x}","crate":"{CRATE:08x}"}}')
    np.testing.assert_allclose(matte(file, "ball"), [1, 0.6, 0, 0], atol=1e-6)
    np.testing.assert_allclose(matte(file, "crate"), [0, 0.4, 1, 0.25], atol=1e-6)
    np.testing.assert_allclose(matte(file, "crate, b*"), [1, 1, 1, 0.25], atol=1e-6)
    np.testing.assert_allclose(matte(file, "*"), [1, 1, 1, 0.25], atol=1e-6)
    with pytest.raises(FlowabsError, match=r"parameter names: there is no object 'boll'.*'ball'") as caught:
        matte(file, "boll")
    assert caught.value.code == "unknown-name"


def test_objects_by_the_hash_of_their_names(tmp_path):
    notes = []
    file, context = written(tmp_path), Context(note=notes.append)
    np.testing.assert_allclose(matte(file, "crate", context), [0, 0.4, 1, 0.25], atol=1e-6)
    assert notes == []
    assert matte(file, "boll", context).max() == 0
    assert "no pixel shows 'boll'" in notes[0]


def test_a_broken_manifest_is_told(tmp_path):
    warnings = []
    found = matte(written(tmp_path, "{"), "ball", Context(warn=warnings.append))
    np.testing.assert_allclose(found, [1, 0.6, 0, 0], atol=1e-6)
    assert "the manifest of CryptoObject cannot be read" in warnings[0]


@pytest.mark.parametrize("version", ["45", "53"])
def test_objects_of_a_file_that_blender_wrote(version):
    ids, coverage = read_id(DATA / "blender" / f"comp_{version}.exr")
    inputs = {"id": ids, "coverage": coverage}
    each = [call_node(ID_MATTE, Context(), inputs, {"names": name})["matte"].pixels for name in ("ball", "crate", "0")]
    assert all(0.05 < matte.mean() < 0.95 for matte in each)
    np.testing.assert_allclose(sum(each), 1, atol=1e-6)
    with pytest.raises(FlowabsError, match=r"no object 'bal' \(did you mean 'ball'\? known: Sun, ball, crate\)"):
        call_node(ID_MATTE, Context(), inputs, {"names": "bal"})


def test_ids_of_an_index_pass():
    ids = Image.from_array(np.array([[0, 7, 12, 7]], np.uint32), type="id")
    found = call_node(ID_MATTE, Context(), {"id": ids}, {"names": "7, 9"})["matte"]
    np.testing.assert_array_equal(found.pixels[0, :, 0], [0, 1, 0, 1])
