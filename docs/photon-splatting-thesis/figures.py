#!/usr/bin/python3
"""Renders the figures of this report: figures.py [FIGURE...] (default: all), with photonctl on the PATH and a daemon that
it reaches. A figure is a strip of the indirect light by several settings. Each panel but the last is scaled by the least
squares exposure against the last, path tracing; its factor, and the mean of marked regions over that of path tracing, are
printed. Needs numpy and OpenImageIO.
"""

import pathlib
import sys

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from strips import render, save, shown, side_by_side  # noqa: E402  docs/strips.py

NORMALISED = "photon_splatting,bounces=1,weighting=normalised"
KERNEL = "photon_splatting,bounces=1,estimator=kernel,shrink=false"
OURS = "photon_splatting,bounces=1,photons=10000"
TRUTH = "path_tracing,indirect_bounces=1"
SIZE = (320, 240)  # pixels of a panel

# scene, view, (METHOD,PARAMETERS, passes) of each panel, regions (name: x0, y0, x1, y1 over the width and height)
FIGURES = {
    "figure-13-corner": (
        "cornell-box-spot", ["--eye", "0.9,4.1,-2.4", "--look-at", "2.6,5.1,-5.4", "--yfov", "0.75"],
        [("photon_mapping,gather=direct,indirect_bounces=1,photons=50000,nearest_photons=200", 8),
         (NORMALISED + ",photons=25000,splat_size_relative=0.25", 4),
         (NORMALISED + ",photons=25000,splat_size_relative=0.25,stratify=true,grid_cells=16,minimum_photons=1,"
          "representative=closest_to_mean", 4),
         (OURS, 16), (TRUTH, 96)], {"back wall at the edge": (0.47, 0.5, 0.5, 0.95), "back wall away from it": (0.05, 0.5, 0.2, 0.95)}),
    "figure-14-plate": (
        "photon-splatting/plate", [],
        [(KERNEL + ",photons=150,splat_size=2,shadow_resolution=64", 1),
         (NORMALISED + ",photons=20000,splat_size=0.8,shadow_resolution=32", 2), (OURS, 16), (TRUTH, 128)],
        {"wall above the plate": (0.42, 0.335, 0.58, 0.36)}),
    "figure-16-skimming-ray": (
        "photon-splatting/skimming-ray", [],
        [(NORMALISED + ",photons=20000,splat_size=0.3", 4), (NORMALISED + ",photons=8000,splat_size=0.9", 4), (OURS, 16),
         (TRUTH, 128)], {}),
    "figure-17-leak": (
        "cornell-box-spot", [],
        [(NORMALISED + ",photons=2500,splat_size_relative=0.25", 8), (NORMALISED + ",photons=2500,splat_size_relative=0.75", 4),
         (OURS, 16), (TRUTH, 96)], {"wall left of the tall block": (0.29, 0.5, 0.335, 0.75),
                                   "front of the short block": (0.5, 0.7, 0.67, 0.9)}),
    "figure-19-chairs": (
        "photon-splatting/chairs", [],
        [(NORMALISED + ",photons=6000,splat_size=1,shadow_resolution=32", 2),
         (KERNEL + ",photons=6000,splat_size=0.5,shadow_resolution=4", 2),
         (KERNEL + ",photons=6000,splat_size=0.5,shadow_resolution=32", 2), (OURS, 16), (TRUTH, 128)],
        {"shadow of the right chair": (0.86, 0.49, 0.98, 0.54)}),
    "figure-20-voxels": (
        "cornell-box-spot", [],
        [(NORMALISED + ",photons=25000,splat_size_relative=0.25", 2),
         (NORMALISED + ",photons=250000,splat_size_relative=0.1,stratify=true,grid_cells=4,minimum_photons=1,"
          "representative=closest_to_mean", 2),
         (OURS, 16), (TRUTH, 96)], {"front of the short block": (0.5, 0.7, 0.67, 0.9)}),
}


def mean_of(image, region):
    height, width = image.shape[:2]
    x0, y0, x1, y1 = region
    return image[int(y0 * height):int(y1 * height), int(x0 * width):int(x1 * width)].mean()


def make(figure):
    scene, view, panels, regions = FIGURES[figure]
    images = [render(scene, view, SIZE, *panel) for panel in panels]
    truth = images[-1]
    exposure = 0.5 / numpy.percentile(truth.mean(axis=2), 95)
    strip = []
    for (method, passes), image in zip(panels, images):
        fit = (image * truth).sum() / (image * image).sum()
        error = ((fit * image - truth) ** 2 / (truth ** 2 + 0.01 * truth.mean() ** 2)).mean()
        ratios = ", ".join(f"{name} {fit * mean_of(image, region) / mean_of(truth, region):.3f}"
                           for name, region in regions.items())
        print(f"{figure}: {method}, {passes} passes: exposure {fit:.4g}, relative_mse then {error:.3g}; {ratios}", flush=True)
        strip.append(shown(fit * image, exposure))
    save(side_by_side(strip), HERE / f"{figure}.jpg")


if __name__ == "__main__":
    for name in sys.argv[1:] or FIGURES:
        make(name)
