#version 460
// The cells of the finest volume that pixels' surfaces lie in, for the layer `volume`: a thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 3
#define INJECTED_BINDING 4
#define VOLUME_BINDING 5
#define OPEN_FACES_BINDING 6
#include "renderer/gbuffer/gbuffer_pixels.glsl"
#include "renderer/methods/light_propagation_volumes/volume_points.glsl"

void main() {
    uint pixel;
    if (!pixel_of_thread(pixel)) return;
    const GBufferPoint point = points[split_point_of(split, pixel % split.width, pixel / split.width)];
    if (!is_lit(point)) return;
    for (uint i = cascades.count; i-- > 0u;) {
        const PropagationGrid grid = cascade_grid(i);
        const ivec3 cell = ivec3(floor(asked_place(grid, point)));
        if (!is_in_grid(grid, cell)) continue;
        const uint place = i * cascades.cells + cell_index(grid, cell);
        CellLight light = injected[place];
        add_light(light, volume[place], 1.0);
        store_rgb(LAYER_VOLUME, pixel, vec3(light.red.x, light.green.x, light.blue.x) / (1.5 * grid.cell_m) / grid.cell_m);
        return;
    }
}
