"""The node that makes the matte of some objects from ids."""

from __future__ import annotations

from flowabs_nodes import filters
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import within

#: The name of all objects.
EVERYTHING = "*"


def run_id_matte(context: Context, id: Image, coverage: Image | None, *, names: str) -> Image:
    from flowabs_nodes.io.manifest import ids_named, manifest_of

    ids, covered = id.pixels[..., 0], None if coverage is None else coverage.pixels[..., 0]
    if names.strip() == EVERYTHING:
        return id.with_pixels(filters.id_matte(ids, None, covered), "matte")
    manifest = manifest_of(id.spec, "" if id.origin is None else id.origin.layer)
    if manifest.note:
        context.warn(manifest.note)

    def tell(name: str, number: int) -> None:
        if not (ids == number).any():
            context.note(f"no pixel shows {name!r} (id {number}, by the hash of its name: there is no manifest)")

    chosen = ids_named(names, manifest.ids, tell)
    return id.with_pixels(filters.id_matte(ids, chosen, covered), "matte")


def _halo(params: object) -> int:
    return 1  # the eight pixels around


ID_MATTE = Node(
    type="id_matte",
    version=1,
    label="Matte of objects",
    category="utility",
    help="Makes the matte of some objects of a render, by their names or ids.",
    doc=(
        "For the ids and the coverage that read_id reads. Names are those of the Cryptomatte's manifest; ids that come "
        "without a manifest are found by the name too, as the hash that a Cryptomatte makes of it. `ball, crate*, 7`: "
        "several names between commas, * and ? stand for any letters, numbers are ids themselves (hexadecimal after "
        '0x), a name with a comma stands in quotes. "*" is everything but the background. With coverage the matte is '
        "anti-aliased: what the object of a pixel leaves of it goes to the objects of the pixels around, so that the "
        "mattes of all objects add up to 1. Thinner things than a pixel are lost, as is what is behind glass."
    ),
    inputs=(
        Port("id", "id", "The id that covers most of each pixel."),
        Port(
            "coverage", "mono", "The part of the pixel that it covers; without it the matte is 0 or 1.", optional=True
        ),
    ),
    outputs=(Port("matte", "matte", "1 where the objects are, 0 elsewhere."),),
    params=(
        Param.string(
            "names",
            EVERYTHING,
            examples=("ball", "ball, crate*", "7, 12"),
            help='Names of objects, * and ? as wildcards, or ids, between commas; "*" is all but the background.',
        ),
    ),
    run=run_id_matte,
    region=within(_halo, "id", "coverage"),
)
