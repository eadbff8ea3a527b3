// How much there is to do, counted on the device: read by the C++ compiler and by glslang.
#ifndef PHOTOND_DEVICE_TILES_SHARED_H
#define PHOTOND_DEVICE_TILES_SHARED_H

struct DeviceTilesState {
    uint groups[3];  // what dispatch_indirect() reads: rows of groups, as CommandList::dispatch_threads() makes them
    uint elements;
    uint tiles;
};
struct DeviceTilesConstants {
    uint count_index;
    uint capacity;
    uint tile;        // elements one group takes
    uint row_groups;  // groups of a full row
};

#endif
