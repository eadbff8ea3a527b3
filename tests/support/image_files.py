"""Image files in memory: made for an upload, or read as they came."""

import os
import tempfile

import numpy
import OpenImageIO as oiio


def encoded(pixels, channels, name="image.exr"):
    """The bytes of an image file of the format that `name` ends in."""
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(channels), "float")
    spec.channelnames = channels
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, name)
        image = oiio.ImageOutput.create(path)
        assert image.open(path, spec) and image.write_image(pixels.astype(numpy.float32)) and image.close()
        with open(path, "rb") as file:
            return file.read()


def decoded_png(body):
    """Display values, 0 to 255, of a PNG's bytes."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "image.png")
        with open(path, "wb") as file:
            file.write(body)
        image = oiio.ImageInput.open(path)
        assert image, oiio.geterror()
        pixels = numpy.asarray(image.read_image("uint8")).astype(float)
        image.close()
    return pixels
