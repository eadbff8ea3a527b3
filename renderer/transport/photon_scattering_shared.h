// How photons' directions are drawn where a mesh is smooth, for both compilers.
#ifndef PHOTOND_PHOTON_SCATTERING_SHARED_H
#define PHOTOND_PHOTON_SCATTERING_SHARED_H

// Share of the directions that are drawn about the geometric normal, of lobes that are no delta. Power grows by its
// inverse at most where the shading frame's draws do not reach.
#define GEOMETRIC_SHARE 0.125f
// The same where light that the surface reflects or refracts like a mirror leaves below the smooth normal's plane.
#define GEOMETRIC_SHARE_BELOW 0.5f

#endif
