// Photons sorted by the cells that they light (photons_by_cell_gpu.h). Define PHOTON_CELLS_BINDING: it and the three after
// it are these buffers' (of set 0).
#ifndef PHOTOND_PHOTONS_BY_CELL_GLSL
#define PHOTOND_PHOTONS_BY_CELL_GLSL

#include "renderer/photons/reflected_photon_shared.h"

layout(set = 0, binding = PHOTON_CELLS_BINDING, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = PHOTON_CELLS_BINDING + 1, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = PHOTON_CELLS_BINDING + 2, scalar) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = PHOTON_CELLS_BINDING + 3, scalar) readonly buffer Values { uint values[]; };

uint photons_of_pass() { return min(state[REFLECTION_PHOTONS], uint(keys.length())); }
/// The first place among the sorted ones that is this cell's or a later one's.
uint first_of_cell(uint cell) {
    uint first = 0u, end = photons_of_pass();
    while (first < end) {
        const uint middle = (first + end) / 2u;
        if (keys[middle] < cell) first = middle + 1u; else end = middle;
    }
    return first;
}
bool is_of_cell(uint place, uint cell) { return place < photons_of_pass() && keys[place] == cell; }

#endif
