// What a ray of a list meets.
#ifndef PHOTOND_MET_VOXEL_GLSL
#define PHOTOND_MET_VOXEL_GLSL

struct MetVoxel {
    uint slot;
    bool where_lit;  // on a side that light reaches, for lists that count
    vec3 place;      // of what is met there: the middle of a disc
};

#endif
