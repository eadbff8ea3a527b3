"""Strips of panels for the reports in this folder: renders by photonctl, which is on the PATH and finds a daemon. Needs numpy
and OpenImageIO.
"""

import pathlib
import subprocess
import tempfile

import numpy
import OpenImageIO as oiio

GAP = 4  # pixels between panels


def photonctl(*arguments):
    subprocess.run(["photonctl", *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def render(scene, view, size, method, passes, layer="indirect"):
    """A layer, height x width x RGB; "beauty" is all light. `method`: METHOD,PARAMETER=VALUE...; `view`: further options."""
    name, *settings = method.split(",")
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "panel.exr"
        photonctl("render", scene, *view, "--width", size[0], "--height", size[1], "--method", name, "--passes", passes,
                  *(word for setting in settings for word in ("--set", setting)), "-o", file)
        source = oiio.ImageInput.open(str(file))
        names = source.spec().channelnames
        pixels = numpy.asarray(source.read_image("float"), dtype=float)
        source.close()
    prefix = "" if layer == "beauty" else layer + "."
    return pixels[:, :, [names.index(prefix + channel) for channel in "RGB"]]


def shown(image, exposure):
    linear = numpy.clip(image * exposure, 0, 1)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def side_by_side(panels):
    """Panels of one height, of values 0 to 1, with white between them."""
    strip = []
    for panel in panels:
        strip += [panel, numpy.ones((panel.shape[0], GAP, 3))]
    return numpy.hstack(strip[:-1])


def save(strip, file):
    pixels = numpy.ascontiguousarray(numpy.rint(255 * strip).astype(numpy.uint8))
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, "uint8")
    spec.attribute("Compression", "jpeg:90")
    out = oiio.ImageOutput.create(str(file))
    if not out or not out.open(str(file), spec) or not out.write_image(pixels) or not out.close():
        raise OSError(f"cannot write {file}: {oiio.geterror()}")
