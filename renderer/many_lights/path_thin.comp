#version 460
// The kept candidates side by side, at equal steps where there is no room for all, a thread a candidate. CPU twin:
// accept() in path_selection.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/path_selection.glsl"
#include "renderer/photons/reflected_photon_shared.h"

layout(set = 0, binding = 0, scalar) readonly buffer Candidates { VplPath candidates[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Ranks { uint ranks[]; };  // kept candidates before each
layout(set = 0, binding = 2, scalar) readonly buffer PathCounts { uint path_counts[PATH_COUNT_WORDS]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Selected { VplPath selected[]; };
layout(set = 0, binding = 4, scalar) buffer State { uint state[REFLECTION_STATE_WORDS]; };

void main() {
    const uint i = flat_index(), kept = path_counts[PATHS_KEPT];
    if (i == 0) state[REFLECTION_PATHS] = min(kept, push.vpls);
    if (i >= push.candidates) return;
    const uint rank = ranks[i], next = i + 1u < push.candidates ? ranks[i + 1u] : kept;
    if (next == rank) return;
    VplPath path = candidates[i];
    uint place = rank;
    if (kept > push.vpls) {
        RandomStream random = numbers_of(PATH_STAGE_THINNING, 0u);
        const uint64_t offset = uint64_t(random_stream_next_bits(random)) * uint64_t(kept) >> 32;
        // The least place whose step, (place kept + offset) / vpls, does not come before the rank.
        const uint64_t from = uint64_t(rank) * uint64_t(push.vpls);
        place = from <= offset ? 0u : uint((from - offset + uint64_t(kept) - 1ul) / uint64_t(kept));
        if (place >= push.vpls || (uint64_t(place) * uint64_t(kept) + offset) / uint64_t(push.vpls) != uint64_t(rank)) return;
        path.weight *= float(kept) / float(push.vpls);
    }
    selected[place] = path;
}
