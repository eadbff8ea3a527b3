// Rays of a pass's photons, in the tracer's state (`state`, declared before).
#ifndef PHOTOND_PHOTON_RAY_COUNT_GLSL
#define PHOTOND_PHOTON_RAY_COUNT_GLSL

void add_photon_rays(uint rays) {
    const uint before = atomicAdd(state[PHOTON_RAYS_WORD], rays);
    if (before + rays < before) atomicAdd(state[PHOTON_RAYS_WORD + 1], 1u);  // the carry
}

#endif
