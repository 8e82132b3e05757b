"""Mixes flowabs with ImageBufAlgo: a cartoon whose outlines are a comper's own.

python mix.py plate.exr cartoon.exr
"""

import sys

import flowabs_oiio as fabuf
import OpenImageIO as oiio
from OpenImageIO import ImageBufAlgo


def cartoon(plate: oiio.ImageBuf) -> oiio.ImageBuf:
    """Return flat colours under lines drawn twice: thin ones, and bold ones over them at half strength."""
    flow = fabuf.etf(plate, radius=5, color=True)
    flat = fabuf.quantize(fabuf.fbl(plate, flow, r_e=15), levels=10, softness=0.5)
    thin = fabuf.fdog(plate, flow, sigma_c=0.8, rho=0.998, softness=2)
    bold = fabuf.fdog(plate, flow, sigma_c=1.6, rho=0.997, softness=2)
    bold = ImageBufAlgo.add(ImageBufAlgo.mul(bold, 0.5), 0.5)
    lines = ImageBufAlgo.mul(thin, bold)
    return ImageBufAlgo.mul(flat, ImageBufAlgo.channels(lines, ("Y", "Y", "Y"), ("R", "G", "B")))


def main(source: str, target: str) -> int:
    """Draw the picture in a file; 0 if it was written."""
    result = cartoon(oiio.ImageBuf(source))
    if result.has_error:
        print(result.geterror() or fabuf.geterror(), file=sys.stderr)
        return 1
    if not result.write(target, "half"):
        print(result.geterror(), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
