#!/usr/bin/python3
"""How much a moving camera's frames of visibility filtering flicker: a walk past the box, a job a frame of one pass, all
of one seed, against path tracing of one bounce, whose seeds differ from frame to frame.

Flicker is the mean squared difference of what changes between two frames and what should, over the reference's square:
mean ((x_t - x_t-1) - (r_t - r_t-1))^2 / (r^2 + 0.01 m^2), of the indirect layer.

    PHOTOND_URL=http://127.0.0.1:8080 docs/visibility-filtering/flicker.py build/bin/photonctl
"""

import pathlib
import subprocess
import sys
import tempfile

import OpenImageIO as oiio
from OpenImageIO import ImageBufAlgo as algo

FRAMES = 16
SCENE = "cornell-box"
STEP_M = 0.04  # of the camera, to the right
SETTINGS = {
    "counts, rays by pixel": [],
    "counts, rays tied to the world": ["world_rays=true"],
    "bits of 6 voxels, rays by pixel": ["lists=bits", "voxels=6"],
    "bits of 6 voxels, rays tied to the world": ["lists=bits", "voxels=6", "world_rays=true"],
    "bits of 6 voxels without the filter, by pixel": ["lists=bits", "voxels=6", "filter_side=1"],
    "bits of 6 voxels without the filter, tied": ["lists=bits", "voxels=6", "filter_side=1", "world_rays=true"],
    "shadow rays": ["visibility=rays"],
}


def indirect(photonctl, folder, frame, method, device, passes, seed, settings):
    file = folder / "frame.exr"
    eye_x = STEP_M * (frame - FRAMES / 2)
    command = [photonctl, "render", SCENE, "-m", method, "--device", device, "--width", "128", "--height", "128",
               "--passes", str(passes), "--seed", str(seed), "--eye", str(eye_x), "2.73", "8", "--look-at", "0", "2.73",
               "-2.8", "-o", str(file)]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True, capture_output=True)
    return algo.channels(oiio.ImageBuf(str(file)), tuple(f"indirect.{c}" for c in "RGB"))


def mean(image):
    return sum(algo.computePixelStats(image).avg) / 3


def mean_square_over(difference, below):
    return mean(algo.div(algo.mul(difference, difference), below))


def main():
    photonctl = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        references = [indirect(photonctl, folder, t, "path_tracing", "cpu", 600, 100 + t, ["indirect_bounces=1"])
                      for t in range(FRAMES)]
        light = sum(map(mean, references)) / FRAMES
        print("| lists | flicker | of one frame: relative_mse |\n|---|--:|--:|")
        for label, settings in SETTINGS.items():
            frames = [indirect(photonctl, folder, t, "visibility_filtering", "gpu", 1, 1, settings)
                      for t in range(FRAMES)]
            flicker, error = [], []
            for t in range(FRAMES):
                below = algo.add(algo.mul(references[t], references[t]), 0.01 * light ** 2)
                error.append(mean_square_over(algo.sub(frames[t], references[t]), below))
                if t > 0:
                    changed = algo.sub(frames[t], frames[t - 1])
                    flicker.append(mean_square_over(
                        algo.sub(changed, algo.sub(references[t], references[t - 1])), below))
            print(f"| {label} | {sum(flicker) / len(flicker):.4f} | {sum(error) / len(error):.4f} |", flush=True)


if __name__ == "__main__":
    main()
