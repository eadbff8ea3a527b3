// The shape of workgroups that sum: for both compilers.
#ifndef PHOTOND_GROUP_SUM_SHARED_H
#define PHOTOND_GROUP_SUM_SHARED_H

#define WARPS 8                 // of a group
#define MOST_GROUP_THREADS 256  // WARPS of 32
#define TILE_ITEMS 16           // elements of a tile for each thread of the group

#define GROUP_SIZE_CONSTANT 32
#define WARP_CONSTANT 33
#define WARPS_IN_SUBGROUPS_CONSTANT 34

#endif
