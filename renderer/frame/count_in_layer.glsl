// Ones added to a layer by many threads: sums of ones do not depend on their order.
#ifndef PHOTOND_COUNT_IN_LAYER_GLSL
#define PHOTOND_COUNT_IN_LAYER_GLSL

#include "renderer/frame/device_image.glsl"

void count_in_layer(uint layer, uint pixel) {
    const uint word = value_place(layer, pixel);
    uint seen = device_layers[word], expected;
    do {
        expected = seen;
        seen = atomicCompSwap(device_layers[word], expected, floatBitsToUint(uintBitsToFloat(expected) + 1.0));
    } while (seen != expected);
}

#endif
