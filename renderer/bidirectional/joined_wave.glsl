// Paths from the eye between the kernels of a wavefront that joins them with light paths: what path_wave.glsl keeps of
// all paths, and their weights.
#ifndef PHOTOND_JOINED_WAVE_GLSL
#define PHOTOND_JOINED_WAVE_GLSL

#include "renderer/eye/path_wave.glsl"
#define BIDIRECTIONAL_BINDING 8
#include "renderer/bidirectional/joined_eye_path.glsl"

layout(set = 0, binding = 9, scalar) buffer PathWeights { SubpathWeights path_weights[]; };

#endif
