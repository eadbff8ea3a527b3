// Which lobes are so narrow that they count as delta, for both compilers (conventions.md, "Materials").
#ifndef PHOTOND_DELTA_SHARED_H
#define PHOTOND_DELTA_SHARED_H

// Smoother GGX lobes are delta: alpha = roughness^2 below 1e-4.
#define DELTA_ROUGHNESS 0.01f
// Rough refraction bends by about alpha |eta - 1|: below this its half-vectors are lost in float's rounding, and the
// lobe is ten times narrower than the narrowest that is not delta.
#define DELTA_REFRACTION 1e-5f

#endif
