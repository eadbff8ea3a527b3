// When the radii of points change (point_radii.h): for both compilers.
#ifndef PHOTOND_POINT_RADII_SHARED_H
#define PHOTOND_POINT_RADII_SHARED_H

#define POINT_FIRST_TEST 16.0f     // photons since the last change after which curved light is first looked for
#define POINT_HALVED 0.70710678f   // the radius, where its square is halved
#define POINT_RADIAL_CURVED 2.5f   // standard deviations past which curvature is more than chance
#define POINT_SECTOR_CURVED 18.0f  // of chi-squared

#endif
