// GLSL twin of transport/light_seen.h: what is known of a shadow before a ray is traced.
#ifndef PHOTOND_LIGHT_SEEN_GLSL
#define PHOTOND_LIGHT_SEEN_GLSL

// LightSeen.
#define LIGHT_SEEN_WHOLE 0u
#define LIGHT_SEEN_NOTHING 1u
#define LIGHT_SEEN_UNKNOWN 2u

#endif
