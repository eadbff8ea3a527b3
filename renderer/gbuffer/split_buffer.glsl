// GLSL twin of gbuffer/split_buffer.h.
#ifndef PHOTOND_SPLIT_BUFFER_GLSL
#define PHOTOND_SPLIT_BUFFER_GLSL

#include "renderer/gbuffer/split_shared.h"

uint split_tile_of(SplitRecord split, uint point) { return point / split.tile_points; }

uint split_point_of(SplitRecord split, uint x, uint y) {
    return (y % split.side * split.side + x % split.side) * split.tile_points + y / split.side * split.tile_width +
           x / split.side;
}

/// Where a pixel is that is counted row by row in the image. False past the last one.
bool split_place_of(SplitRecord split, uint pixel, out uint x, out uint y, out uint point) {
    x = pixel % split.width, y = pixel / split.width;
    point = split_point_of(split, x, y);
    return pixel < split.width * split.height;
}

/// NO_PIXEL for padding.
uint split_pixel_of(SplitRecord split, uint point) {
    const uint tile = point / split.tile_points, place = point % split.tile_points;
    const uint x = place % split.tile_width * split.side + tile % split.side;
    const uint y = place / split.tile_width * split.side + tile / split.side;
    const bool seen = place < split.tile_width * split.tile_height && x < split.width && y < split.height;
    return seen ? y * split.width + x : NO_PIXEL;
}

/// SplitLayout::point_shown_at().
uint split_point_shown_at(SplitRecord split, uint x, uint y) {
    const uint tile = y / split.tile_height * split.side + x / split.tile_width;
    return tile * split.tile_points + y % split.tile_height * split.tile_width + x % split.tile_width;
}

#endif
