"""How far the pictures of two renderers are apart: in the means of the channels and of 16 regions."""
import numpy

REGIONS = 4  # a side


def regions(image):
    """Mean radiance of REGIONS x REGIONS blocks, each with three channels."""
    rows = numpy.array_split(image, REGIONS, axis=0)
    return numpy.array([block.mean(axis=(0, 1)) for row in rows
                        for block in numpy.array_split(row, REGIONS, axis=1)])


def difference(ours, theirs):
    """Of several pictures of each renderer, with other seeds, as the cells of a row: the ratio of the
    channels' means; the median and the greatest difference of a region in standard errors; and from
    where to where the ratios of the regions lie."""
    a, b = (numpy.array([regions(p) for p in pictures]) for pictures in (ours, theirs))
    error = numpy.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / len(ours))
    a, b = a.mean(axis=0), b.mean(axis=0)
    z = abs(a - b) / numpy.maximum(error, 1e-12)
    mine, other = a.sum(axis=1), b.sum(axis=1)
    lit = other > 1e-4 * other.max()
    off = 100 * (mine[lit] / other[lit] - 1)
    ratio = numpy.mean(ours, axis=(0, 1, 2)) / numpy.mean(theirs, axis=(0, 1, 2))
    return (" ".join(f"{r:.4f}" for r in ratio), f"{numpy.median(z):.1f}, {z.max():.1f}",
            f"{off.min():+.1f} to {off.max():+.1f} %")
