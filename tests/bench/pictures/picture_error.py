"""How far a picture is from another for the eye: FLIP and SSIM.

FLIP: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild, "FLIP: A Difference Evaluator for
Alternating Images", HPG 2020, for pictures of low dynamic range. SSIM: Wang, Bovik, Sheikh and Simoncelli, "Image
Quality Assessment: From Error Visibility to Structural Similarity", IEEE TIP 2004, on luma.

Pictures are arrays (height, width, 3) of sRGB, 0 to 1.
"""
import numpy

# A screen 0.7 m wide with 3840 pixels, seen from 0.7 m: the paper's.
PIXELS_PER_DEGREE = 0.7 * 3840 / 0.7 * numpy.pi / 180

_TO_XYZ = numpy.array([[10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
                       [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
                       [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382]])
_WHITE = _TO_XYZ.sum(axis=1)


def linear(srgb):
    return numpy.where(srgb <= 0.04045, srgb / 12.92, ((numpy.maximum(srgb, 0.04045) + 0.055) / 1.055) ** 2.4)


def srgb(light):
    light = numpy.clip(light, 0, 1)
    return numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * numpy.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055)


def _opponents(light):
    """YCxCz of linear light."""
    x, y, z = numpy.moveaxis(light @ _TO_XYZ.T / _WHITE, -1, 0)
    return numpy.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def _light(opponents):
    y, cx, cz = numpy.moveaxis(opponents, -1, 0)
    y = (y + 16) / 116
    return numpy.stack([y + cx / 500, y, y - cz / 200], axis=-1) * _WHITE @ numpy.linalg.inv(_TO_XYZ).T


def _hunt_lab(light):
    """L*a*b*, whose colours fade with the lightness (Hunt)."""
    t = light @ _TO_XYZ.T / _WHITE
    edge = 6 / 29
    x, y, z = numpy.moveaxis(numpy.where(t > edge**3, numpy.cbrt(t), t / (3 * edge**2) + 4 / 29), -1, 0)
    lightness = 116 * y - 16
    return numpy.stack([lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)], axis=-1)


def _hyab(a, b):
    d = a - b
    return numpy.abs(d[..., 0]) + numpy.hypot(d[..., 1], d[..., 2])


def _convolved(image, kernel):
    """With an odd kernel; beyond its edge the image goes on as it is there."""
    r = kernel.shape[0] // 2
    padded = numpy.pad(image, r, mode="edge")
    size = [n + 2 * r for n in padded.shape]
    full = numpy.fft.irfft2(numpy.fft.rfft2(padded, size) * numpy.fft.rfft2(kernel, size), size)
    return full[2 * r : 2 * r + image.shape[0], 2 * r : 2 * r + image.shape[1]]


def _contrast_kernels(per_degree):
    """What the eye resolves of each opponent channel, as kernels that sum to 1."""
    terms = [(1, 0.0047, 0, 1e-5), (1, 0.0053, 0, 1e-5), (34.1, 0.04, 13.5, 0.025)]
    r = int(numpy.ceil(3 * numpy.sqrt(0.04 / (2 * numpy.pi**2)) * per_degree))
    x = numpy.arange(-r, r + 1) / per_degree
    z = x[:, None] ** 2 + x[None, :] ** 2
    for a1, b1, a2, b2 in terms:
        g = sum(a * numpy.sqrt(numpy.pi / b) * numpy.exp(-(numpy.pi**2) * z / b) for a, b in ((a1, b1), (a2, b2)))
        yield g / g.sum()


def _feature_kernel(per_degree, edges):
    deviation = 0.5 * 0.082 * per_degree
    r = int(numpy.ceil(3 * deviation))
    x, y = numpy.meshgrid(numpy.arange(-r, r + 1), numpy.arange(-r, r + 1))
    g = numpy.exp(-(x * x + y * y) / (2 * deviation**2))
    g = -x * g if edges else (x * x / deviation**2 - 1) * g
    return numpy.where(g < 0, g / -g[g < 0].sum(), g / g[g > 0].sum())


def _features(luma, per_degree, edges):
    kernel = _feature_kernel(per_degree, edges)
    return numpy.hypot(_convolved(luma, kernel), _convolved(luma, kernel.T))


def flip(reference, test, per_degree=PIXELS_PER_DEGREE):
    """The error at each pixel, 0 to 1."""
    seen, lumas = [], []
    for image in (reference, test):
        opponents = _opponents(linear(image))
        filtered = [_convolved(opponents[..., k], g) for k, g in enumerate(_contrast_kernels(per_degree))]
        seen.append(_hunt_lab(numpy.clip(_light(numpy.stack(filtered, axis=-1)), 0, 1)))
        lumas.append((opponents[..., 0] + 16) / 116)
    green, blue = _hunt_lab(numpy.array([0.0, 1, 0])), _hunt_lab(numpy.array([0.0, 0, 1]))
    most = _hyab(green, blue) ** 0.7
    color = _hyab(*seen) ** 0.7
    bend = 0.4 * most
    color = numpy.where(color < bend, 0.95 / bend * color, 0.95 + (color - bend) / (most - bend) * 0.05)
    differ = [numpy.abs(_features(lumas[0], per_degree, e) - _features(lumas[1], per_degree, e)) for e in (True, False)]
    feature = numpy.clip((numpy.maximum(*differ) / numpy.sqrt(2)) ** 0.5, 0, 1)
    return color ** (1 - feature)


def ssim(reference, test):
    """The mean over the pictures: 1 where they are the same."""
    x, y = (image @ numpy.array([0.2126, 0.7152, 0.0722]) for image in (reference, test))
    ticks = numpy.arange(-5, 6)
    g = numpy.exp(-(ticks**2) / (2 * 1.5**2))
    kernel = numpy.outer(g, g) / g.sum() ** 2
    mx, my = _convolved(x, kernel), _convolved(y, kernel)
    xx, yy, xy = (_convolved(a, kernel) - b for a, b in ((x * x, mx * mx), (y * y, my * my), (x * y, mx * my)))
    c1, c2 = 0.01**2, 0.03**2
    return float(((2 * mx * my + c1) * (2 * xy + c2) / ((mx * mx + my * my + c1) * (xx + yy + c2))).mean())
