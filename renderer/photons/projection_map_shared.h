// A projection map's tables as shaders see them (projection_map.glsl): words, and the choice's cumulative table as
// floats. For both compilers.
#ifndef PHOTOND_PROJECTION_MAP_SHARED_H
#define PHOTOND_PROJECTION_MAP_SHARED_H

#define GUIDED_ID 41  // specialisation constant: there is a map

// The words begin with:
#define GUIDE_GRIDS 0    // how many lights have bins
#define GUIDE_BINS 1     // of all of them
#define GUIDE_CHOICE 2   // where the choice's guide table begins ...
#define GUIDE_CHOICES 3  // ... and its intervals
#define GUIDE_REST 4     // where the lights without bins begin
#define GUIDE_HEADER 5
// Then of each light with bins, by its first bin:
#define GUIDE_GRID_LIGHT 0
#define GUIDE_GRID_FIRST_BIN 1
#define GUIDE_GRID_PLACES 2
#define GUIDE_GRID_DIRECTIONS 3
#define GUIDE_GRID 4

#endif
