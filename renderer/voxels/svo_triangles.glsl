// Triangles by their number among all instances' (first_triangles_of()). Define SVO_FIRST_TRIANGLES_BINDING (of set 0)
// before.
#ifndef PHOTOND_SVO_TRIANGLES_GLSL
#define PHOTOND_SVO_TRIANGLES_GLSL

#extension GL_EXT_scalar_block_layout : require

layout(set = 0, binding = SVO_FIRST_TRIANGLES_BINDING, scalar) readonly buffer SvoFirstTriangles {
    uint svo_first_triangles[];
};

/// The instance, and the triangle of its mesh.
uvec2 svo_triangle(uint number, uint instance_count) {
    uint low = 0u, high = instance_count;  // the last instance that begins at or before the number is in [low, high)
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (svo_first_triangles[middle] <= number) low = middle; else high = middle;
    }
    return uvec2(low, number - svo_first_triangles[low]);
}

#endif
