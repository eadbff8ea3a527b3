// The grid of facets by which the reflectance of a solid's rough interface is found, for both compilers.
#ifndef PHOTOND_BSDF_LOBE_ALBEDOS_SHARED_H
#define PHOTOND_BSDF_LOBE_ALBEDOS_SHARED_H

#define GLASS_ALBEDO_AZIMUTHS 16
#define GLASS_ALBEDO_CAPS 32
// From within, where total reflection makes a step.
#define GLASS_ALBEDO_AZIMUTHS_WITHIN 24
#define GLASS_ALBEDO_CAPS_WITHIN 40

#endif
