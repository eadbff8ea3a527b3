#!/usr/bin/python3
"""How much a moving camera's frames of visibility filtering flicker: a walk past the box, a job a frame of one pass,
against path tracing of one bounce, whose seeds differ from frame to frame. All frames have one seed, or, where numbers
are said to be fresh, one each.

Flicker is the mean of what changes between two frames and should not, squared, over the reference's square, of the
indirect layer. With x a frame, u and v references of different seeds, d the change since the frame before:

    mean ((dx - du) (dx - dv)) / (r^2 + 0.01 m^2),   r = (u + v) / 2, m the mean of all r

so that the references' own noise adds nothing. It is printed over the whole image and away from edges: a pixel of one
sample lies on one side of an edge or on the other, whatever lights it.

    PHOTOND_URL=http://127.0.0.1:8080 docs/visibility-filtering/flicker.py build/bin/photonctl
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy
import OpenImageIO as oiio

FRAMES = 16
SCENE = "cornell-box"
STEP_M = 0.04  # of the camera, to the right
EDGE = 0.25    # share of the brighter one by which two neighbours of the reference differ at an edge
TIED = ["world_rays=true"]
LISTS = {
    "counts": [],
    "counts without the filter": ["filter_side=1"],
    "bits of 6 voxels": ["lists=bits", "voxels=6"],
    "bits of 6 voxels without the filter": ["lists=bits", "voxels=6", "filter_side=1"],
}


def indirect(photonctl, folder, frame, method, device, passes, seed, settings):
    """rows x columns x RGB"""
    file = folder / "frame.exr"
    eye_x = STEP_M * (frame - FRAMES / 2)
    command = [photonctl, "render", SCENE, "-m", method, "--device", device, "--width", "128", "--height", "128",
               "--passes", str(passes), "--seed", str(seed), "--eye", str(eye_x), "2.73", "8", "--look-at", "0", "2.73",
               "-2.8", "-o", str(file)]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True, capture_output=True)
    image = oiio.ImageInput.open(str(file))  # not ImageBuf: its cache goes by the file's name
    names = list(image.spec().channelnames)
    pixels = image.read_image(oiio.FLOAT)
    image.close()
    return pixels[..., [names.index(f"indirect.{c}") for c in "RGB"]].astype(float)


def near_edges(image, light):
    """Pixels that differ from one of the eight about them."""
    grey = image.mean(-1)
    found = numpy.zeros(grey.shape, bool)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            other = numpy.roll(grey, (down, right), (0, 1))
            found |= abs(other - grey) > EDGE * numpy.maximum(other, grey) + 0.05 * light
    return found


class Walk:
    """The references of all frames, and what they say of a method's."""

    def __init__(self, photonctl, folder):
        self.u, self.v = ([indirect(photonctl, folder, t, "path_tracing", "cpu", 600, first + t,
                                    ["indirect_bounces=1"]) for t in range(FRAMES)] for first in (100, 200))
        r = [(u + v) / 2 for u, v in zip(self.u, self.v)]
        light = numpy.mean(r)
        self.below = [image ** 2 + 0.01 * light ** 2 for image in r]
        edges = [near_edges(image, light) for image in r]
        self.inside = [None] + [~(edges[t] | edges[t - 1]) for t in range(1, FRAMES)]

    def errors(self, frames):
        return numpy.mean([(x - u) * (x - v) / below
                           for x, u, v, below in zip(frames, self.u, self.v, self.below)])

    def flicker(self, frames):
        """Of the whole image, and away from edges."""
        whole, inside = [], []
        for t in range(1, FRAMES):
            dx, du, dv = (images[t] - images[t - 1] for images in (frames, self.u, self.v))
            changed = (dx - du) * (dx - dv) / self.below[t]
            whole.append(changed.mean())
            inside.append(changed[self.inside[t]].mean())
        return numpy.mean(whole), numpy.mean(inside)


def main():
    photonctl = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        walk = Walk(photonctl, folder)
        print("| lists | flicker | away from edges | of one frame: relative_mse |\n|---|--:|--:|--:|")

        def show(label, settings, fresh):
            frames = [indirect(photonctl, folder, t, "visibility_filtering", "gpu", 1, 1 + t if fresh else 1, settings)
                      for t in range(FRAMES)]
            whole, inside = walk.flicker(frames)
            print(f"| {label} | {whole:.4f} | {inside:.6f} | {walk.errors(frames):.4f} |", flush=True)

        for label, settings in LISTS.items():
            show(f"{label}, fresh numbers", settings, True)
            show(f"{label}, rays by pixel", settings, False)
            show(f"{label}, rays tied to the world", settings + TIED, False)
        show("shadow rays, fresh numbers", ["visibility=rays"], True)
        show("shadow rays", ["visibility=rays"], False)


if __name__ == "__main__":
    main()
