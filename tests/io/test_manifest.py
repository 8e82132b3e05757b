"""Names of objects for ids: from the manifest of a Cryptomatte, or by its hash."""

from __future__ import annotations

import json

import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.io.manifest import cryptomatte_id, ids_named, manifest_of, murmur3

#: As Blender wrote them.
BLENDER = {
    "floor": 0x7819C83C,
    "suzanne": 0xA0083E7F,
    "ring": 0x956D4CBD,
    "crate": 0xD15E1B1E,
    "ball": 0x645D3BC4,
    "Sun": 0xEE8D1AE3,
    "object": 0x055EC73D,
}


def spec(**manifests: str) -> oiio.ImageSpec:
    """Return a header with a Cryptomatte of each name, with this manifest, or none where it is empty."""
    made = oiio.ImageSpec(4, 4, 1, "float")
    for i, (name, manifest) in enumerate(manifests.items()):
        made.attribute(f"cryptomatte/{i}abc/name", name)
        if manifest:
            made.attribute(f"cryptomatte/{i}abc/manifest", manifest)
    return made


def named(names: str, known: dict[str, int]) -> list[int]:
    return ids_named(names, known, lambda name, number: pytest.fail(f"{name} is not in the manifest"))


def test_the_hash_is_murmur3() -> None:
    assert murmur3(b"") == 0
    assert murmur3(b"", 1) == 0x514E28B7
    assert murmur3(b"\0\0\0\0") == 0x2362F9DE
    assert murmur3(b"test") == 0xBA6BD213
    assert murmur3(b"Hello, world!") == 0xC0363E43
    assert murmur3(b"The quick brown fox jumps over the lazy dog", 0x9747B28C) == 0x2FA826CD


def test_ids_are_those_of_renderers() -> None:
    assert {name: cryptomatte_id(name) for name in BLENDER} == BLENDER


def test_an_id_is_always_a_normal_float() -> None:
    numbers = [cryptomatte_id(f"object{i}") for i in range(3000)]
    changed = [i for i, number in enumerate(numbers) if number != murmur3(f"object{i}".encode())]
    assert changed  # about one in 128
    assert all(0 < (number >> 23 & 0xFF) < 0xFF for number in numbers)


def test_names_are_looked_up() -> None:
    assert named("ring", BLENDER) == [BLENDER["ring"]]
    assert named(" ring ,ball,, ", BLENDER) == [BLENDER["ring"], BLENDER["ball"]]
    assert named('"a, b"', {"a, b": 5}) == [5]


def test_wildcards_stand_for_letters() -> None:
    assert set(named("*r*", BLENDER)) == {BLENDER["floor"], BLENDER["ring"], BLENDER["crate"]}
    assert named("?ing", BLENDER) == [BLENDER["ring"]]
    assert named("a[1]*", {"a[1]b": 3, "a1": 4}) == [3]


def test_numbers_are_ids_unless_an_object_is_called_so() -> None:
    assert named("7, 0x10, 4294967295", BLENDER) == [7, 16, 2**32 - 1]
    assert named("7", {"7": 99}) == [99]
    assert named("7", {}) == [7]


def test_without_a_manifest_the_id_is_the_hash_of_the_name() -> None:
    told = []
    found = ids_named("ball, 3", {}, lambda name, number: told.append((name, number)))
    assert found == [BLENDER["ball"], 3]
    assert told == [("ball", BLENDER["ball"])]
    assert ids_named("4294967296", {}, lambda *_: None) == [cryptomatte_id("4294967296")]  # no id: a name


def test_a_name_that_is_not_there_is_an_error_with_the_nearest_one() -> None:
    with pytest.raises(ArgumentError, match=r"no object 'suzane' \(did you mean 'suzanne'\?.*known: Sun, ball"):
        named("ball, suzane", BLENDER)
    with pytest.raises(ArgumentError, match=r"called like 'crates\*'.*crate"):
        named("crates*", BLENDER)
    with pytest.raises(ArgumentError, match=r"and 28 more"):
        named("nothing", {f"object{i:02}": i for i in range(40)})
    with pytest.raises(ArgumentError, match=r"'ball.' has a wildcard, but the ids come without"):
        named("ball*", {})
    with pytest.raises(ArgumentError, match="expected a name, found none"):
        named(" , ", BLENDER)


def test_the_manifest_is_that_of_the_layer() -> None:
    objects, materials = json.dumps({"ball": "0000000a"}), json.dumps({"wood": "0000000B"})
    header = spec(CryptoObject=objects, CryptoMaterial=materials)
    assert manifest_of(header, "CryptoObject00").ids == {"ball": 10}
    assert manifest_of(header, "CryptoMaterial00").ids == {"wood": 11}
    assert manifest_of(header).ids == {"ball": 10, "wood": 11}
    assert manifest_of(header, "Depth").ids == {"ball": 10, "wood": 11}
    assert manifest_of(spec(crypto="{}", crypto_object=objects), "crypto_object00").ids == {"ball": 10}


def test_a_manifest_that_is_missing_or_broken_names_nothing() -> None:
    assert manifest_of(oiio.ImageSpec(4, 4, 1, "float")) == ({}, "")
    assert manifest_of(spec(CryptoObject="")) == ({}, "")
    for broken in ('{"ball": ', "[1, 2]", '{"ball": "xyz"}'):
        found = manifest_of(spec(CryptoObject=broken))
        assert found.ids == {}
        assert "the manifest of CryptoObject cannot be read" in found.note
