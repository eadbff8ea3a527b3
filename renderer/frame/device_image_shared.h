// The layers of a pass on the device: one buffer of words, which begins with where each layer lies. For both compilers.
#ifndef PHOTOND_DEVICE_IMAGE_SHARED_H
#define PHOTOND_DEVICE_IMAGE_SHARED_H

#include "renderer/film/layers_shared.h"

// A layer that is kept is a plane of floats, as large as the film, for each of its channels; those of colours and
// vectors lie side by side. The word of a layer's number is the number of the plane's first word; 0: the layer is not
// kept. So a pipeline is compiled once for images of all sizes and of all choices of layers.
#define LAYER_HITS LAYER_COUNT  // no layer of the image: 1 where a surface was met, else 0
#define LAYER_PLACES (LAYER_COUNT + 1)

#endif
