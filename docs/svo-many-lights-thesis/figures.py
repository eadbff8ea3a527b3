#!/usr/bin/python3
"""Renders the figures of this report: figures.py SCENES [FIGURE...] (default: all), SCENES the folder of
cornell_dragon_buddha.glb and sponza_crytek.glb, with photonctl on the PATH and a daemon that it reaches. A figure is a strip of
one layer by several settings, all at the exposure of the last, path tracing; relative_mse against that is printed. Needs
numpy and OpenImageIO.
"""

import pathlib
import sys

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from strips import render, save, shown, side_by_side  # noqa: E402  docs/strips.py

THESIS = "svo_many_lights,visibility=svo,vpl_choice=interleaved,interleave=4,filter=8,direct=shadow_maps,repay=false,narrow_lobes=false"
OURS = "svo_many_lights,vpls=1024,visibility=rays,vpl_choice=resampled,repay=true"
TRUTH = "path_tracing,indirect_bounces=1"
BOX, SPONZA = "cornell_dragon_buddha.glb", "sponza_crytek.glb"
IN_BOX, IN_SPONZA = THESIS + ",voxel_resolution=128", THESIS + ",voxel_resolution=256"


def cameras(name):
    return ["--camera", name]


def of_sponza(camera, vpls):
    """As Figure 5.2: all light, one frame of the thesis'."""
    return (SPONZA, cameras(camera), (320, 180), "beauty",
            [(f"{IN_SPONZA},vpls={vpls}", 1), (OURS, 16), (TRUTH, 128)])


# scene, view, pixels of a panel, layer, (METHOD,PARAMETERS, passes) of each panel
FIGURES = {
    "figure-5-1": (BOX, [], (256, 256), "indirect",
                   [(IN_BOX + ",vpls=512", 1), (IN_BOX + ",vpls=2048", 1), (OURS, 1), (OURS, 16), (TRUTH, 128)]),
    "figure-5-2-main": of_sponza("CameraMain", 1024),
    "figure-5-2-alternate": of_sponza("CameraAlternate", 1024),
    "figure-5-2-balcony": of_sponza("CameraBalcony", 1024),
    "figure-5-2-alcove": of_sponza("CameraAlcove", 2048),
}


def make(figure, scenes):
    scene, view, size, layer, panels = FIGURES[figure]
    images = [render(scenes / scene, view, size, method, passes, layer) for method, passes in panels]
    truth = images[-1]
    exposure = 0.7 / numpy.percentile(truth.mean(axis=2), 95)
    floor = 0.01 * truth.mean() ** 2
    for (method, passes), image in zip(panels, images):
        error = ((image - truth) ** 2 / (truth ** 2 + floor)).mean()
        print(f"{figure}: {method}, {passes} passes: {layer}:relative_mse {error:.3g}, mean {image.mean() / truth.mean():.3f}",
              flush=True)
    save(side_by_side([shown(image, exposure) for image in images]), HERE / f"{figure}.jpg")


if __name__ == "__main__":
    for name in sys.argv[2:] or FIGURES:
        make(name, pathlib.Path(sys.argv[1]))
