"""Pictures as Mitsuba 3 reads them."""
import os

import mitsuba
import numpy

mitsuba.set_variant(os.environ.get("MITSUBA_VARIANT", "scalar_rgb"))
def read(path):
    return numpy.array(mitsuba.Bitmap(path).convert(
        mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, srgb_gamma=False))
