"""A shot with passes of Blender 4.5 and 5.2 (tools/blender/passes_shot.py): all that lines are drawn from is found."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes.image import Image
from flowabs_nodes.io.read_id import read_id
from flowabs_nodes.io.read_motion import read_motion
from flowabs_nodes.io.read_passes import read_depth, read_normal

DATA = Path(__file__).parents[1] / "data" / "blender"
OBJECTS = {"floor", "crate", "cabinet", "ball", "sheet", "ring"}
MATERIALS = OBJECTS | {"stripe"}


def manifest(image: Image) -> dict[int, str]:
    """Return the names of a Cryptomatte's ids, by id."""
    header = {each.name: each.value for each in image.spec.extra_attribs if each.name.startswith("cryptomatte/")}
    assert image.origin is not None
    name = next(key for key, value in header.items() if value == image.origin.layer.removesuffix("00"))
    texts = json.loads(header[name.replace("/name", "/manifest")])
    return {int(value, 16): name for name, value in texts.items()}


@pytest.fixture(params=["45", "52"])
def version(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def frame(version: str) -> Path:
    return DATA / f"passes_{version}.0002.exr"


@pytest.mark.parametrize(("layer", "names"), [("", OBJECTS), ("material", MATERIALS)])
def test_a_cryptomatte_names_its_ids(frame: Path, layer: str, names: set[str]) -> None:
    ids, coverage = read_id(frame, layer=layer)
    known = manifest(ids)
    assert {known[each] for each in np.unique(ids.pixels) if each} == names
    assert (ids.pixels == 0).any()
    assert coverage.pixels.min() > 0.2
    assert coverage.pixels.max() <= 1.001


@pytest.mark.parametrize(
    ("crypto", "index", "count"), [("", "IndexOB", len(OBJECTS)), ("material", "IndexMA", len(MATERIALS))]
)
def test_an_index_divides_the_picture_as_the_cryptomatte_does(frame: Path, crypto: str, index: str, count: int) -> None:
    """But at edges, where an index is that of one sample."""
    ids, numbers = (read_id(frame, layer=layer)[0].pixels[..., 0] for layer in (crypto, index))
    assert set(np.unique(numbers)) == set(range(count + 1))
    pairs, shares = np.unique(np.stack([ids.ravel(), numbers.ravel()]), axis=1, return_counts=True)
    usual = {int(each): max(shares[pairs[0] == each]) for each in np.unique(ids)}
    assert sum(usual.values()) / ids.size > 0.93


def test_the_stripe_is_a_material_of_the_crate(frame: Path) -> None:
    objects, materials = read_id(frame)[0], read_id(frame, layer="material")[0]
    stripe = next(each for each, name in manifest(materials).items() if name == "stripe")
    crate = next(each for each, name in manifest(objects).items() if name == "crate")
    on_stripe = objects.pixels[materials.pixels == stripe]
    assert on_stripe.size > 80
    assert (on_stripe == crate).mean() > 0.9


def test_depth_and_normals_know_the_sky(frame: Path) -> None:
    sky = read_id(frame)[0].pixels[..., 0] == 0
    depth, normal = read_depth(frame).pixels[..., 0], read_normal(frame).pixels
    inside = np.zeros_like(sky)
    inside[:10] = True
    assert (depth[inside & sky] == 1e10).all()
    assert (normal[inside & sky] == 0).all()
    assert (depth[~sky] < 60).mean() > 0.98
    lengths = np.linalg.norm(normal[~sky], axis=1)
    assert np.median(lengths) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize(("step", "pair"), [(-1, (0, 1)), (1, (2, 3))])
def test_motion_leads_to_the_same_object_on_the_frame_before_and_after(
    version: str, step: int, pair: tuple[int, int]
) -> None:
    """(x + X, y - Y) on the frame before, (x - Z, y + W) on the next: where the ball is, the ball is found."""
    here, there = (read_id(DATA / f"passes_{version}.{frame:04d}.exr")[0] for frame in (2, 2 + step))
    motion = read_motion(DATA / f"passes_{version}.0002.exr").pixels
    ball, ring = (next(each for each, name in manifest(here).items() if name == thing) for thing in ("ball", "ring"))
    y, x = np.nonzero(here.pixels[..., 0] == ball)
    u, v = (motion[y, x, channel] * (1 if step < 0 else -1) for channel in pair)
    assert np.abs(u).mean() > 2
    rows, columns = np.rint(y - v).astype(int), np.rint(x + u).astype(int)
    seen = np.isin(there.pixels[..., 0], (ball, ring))  # the ring is in front of it on the first frame
    moved, still = seen[rows.clip(0, 53), columns.clip(0, 95)], seen[y, x]
    assert moved.mean() > 0.93 > still.mean()
