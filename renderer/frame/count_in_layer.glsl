// Ones added to a layer by many threads: sums of ones do not depend on their order. Define LAYER_WORDS (the image's floats
// as uints) and PLANES before.
#ifndef PHOTOND_COUNT_IN_LAYER_GLSL
#define PHOTOND_COUNT_IN_LAYER_GLSL

void count_in_layer(uint plane, uint pixel) {
    const uint word = plane * (uint(LAYER_WORDS.length()) / PLANES) + pixel;
    uint seen = LAYER_WORDS[word], expected;
    do {
        expected = seen;
        seen = atomicCompSwap(LAYER_WORDS[word], expected, floatBitsToUint(uintBitsToFloat(expected) + 1.0));
    } while (seen != expected);
}

#endif
