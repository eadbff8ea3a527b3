// A path from the eye to and from what a wavefront keeps of it.
#ifndef PHOTOND_PATH_STATE_GLSL
#define PHOTOND_PATH_STATE_GLSL

#include "renderer/eye/eye_scene.glsl"
#include "renderer/eye/path_wavefront_shared.h"

PathState pack_path(EyePath path, Ray ray, uint key) {
    PathState s;
    s.throughput = path.throughput, s.pdf_sa = path.pdf_sa;
    s.position = path.position, s.eta_scale = path.eta_scale;
    s.lit_normal = path.lit_normal, s.pixel = path.pixel;
    s.origin = ray.origin, s.key = key, s.direction = ray.direction;
    s.flags = path.scatterings | (path.delta ? PATH_DELTA : 0u) | (path.caustic ? PATH_CAUSTIC : 0u);
    s.media[0] = path.media.materials.x, s.media[1] = path.media.materials.y;
    s.media[2] = path.media.materials.z, s.media[3] = path.media.materials.w;
    return s;
}

EyePath unpack_path(PathState s) {
    EyePath path;
    path.throughput = s.throughput, path.pdf_sa = s.pdf_sa;
    path.position = s.position, path.eta_scale = s.eta_scale;
    path.lit_normal = s.lit_normal, path.pixel = s.pixel;
    path.scatterings = s.flags & ~(PATH_DELTA | PATH_CAUSTIC);
    path.delta = (s.flags & PATH_DELTA) != 0, path.caustic = (s.flags & PATH_CAUSTIC) != 0;
    path.media = MediumStack(NEEDS_SOLID_GLASS ? uvec4(s.media[0], s.media[1], s.media[2], s.media[3]) : uvec4(VACUUM));
    return path;
}

Ray ray_of(PathState s) { return Ray(s.origin, s.direction, INFINITY); }

#endif
