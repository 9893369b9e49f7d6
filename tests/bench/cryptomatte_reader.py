#!/usr/bin/env python3
"""Reads the Cryptomattes of a file by a reader that is not qray's: cryptomatte-api (PyPI).

    build/release/bin/qray render lamp-room --size 256x256 --spp 4 \\
        --passes cryptomatte-object,cryptomatte-material --passes-out layers.exr -o room.png
    python3 tests/bench/cryptomatte_reader.py layers.exr

Prints how much of the picture each name covers, and fails where the masks of a pixel do not sum to
one: in a closed room every pixel shows something, and few show more than six things.
"""
import sys

import cryptomatte_api
import numpy


def main():
    mattes = cryptomatte_api.Cryptomatte.load(sys.argv[1], load_preview=False)
    bad = 0
    for matte in mattes if isinstance(mattes, list) else [mattes]:
        masks = {name: numpy.asarray(mask, dtype=float) for name, mask in matte.masks().items()}
        far = numpy.abs(sum(masks.values()) - 1)
        print(f"{len(masks)} names; sums differ from 1 by at most {far.max():.1e}")
        for name, mask in sorted(masks.items(), key=lambda item: -item[1].sum()):
            print(f"  {mask.mean():8.3%}  {name}")
        bad += far.max() > 1e-5
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
