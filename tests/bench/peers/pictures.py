"""Pictures as Mitsuba 3 reads them, and the means of their regions."""
import os

import mitsuba
import numpy

mitsuba.set_variant(os.environ.get("MITSUBA_VARIANT", "scalar_rgb"))
REGIONS = 4  # a side


def regions(image):
    """Mean radiance of REGIONS x REGIONS blocks, each with three channels."""
    rows = numpy.array_split(image, REGIONS, axis=0)
    return numpy.array([block.mean(axis=(0, 1)) for row in rows
                        for block in numpy.array_split(row, REGIONS, axis=1)])


def read(path):
    return numpy.array(mitsuba.Bitmap(path).convert(
        mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, srgb_gamma=False))
