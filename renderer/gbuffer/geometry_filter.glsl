// GLSL twin of gbuffer/geometry_filter.cpp. Define FILTER_POINTS and FILTER_IRRADIANCE before: the arrays of GBufferPoint
// and vec3, in the order of the split buffer.
#ifndef PHOTOND_GEOMETRY_FILTER_GLSL
#define PHOTOND_GEOMETRY_FILTER_GLSL

#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/geometry_filter_shared.h"
#include "renderer/gbuffer/split_buffer.glsl"

bool geometry_filter_takes(uint kind) { return (kind & (GBUFFER_POINT | GBUFFER_GENERAL)) == GBUFFER_POINT; }

/// The filtered irradiance of the point, which is that of a pixel.
vec3 filter_geometry_aware(SplitRecord split, GeometryFilter settings, uint point) {
    vec3 sum = FILTER_IRRADIANCE[point];
    if (settings.width < 2 || !geometry_filter_takes(FILTER_POINTS[point].kind)) return sum;
    const uint pixel = split_pixel_of(split, point);
    const vec3 position = FILTER_POINTS[point].position, normal = FILTER_POINTS[point].normal;
    const vec3 plane = FILTER_POINTS[point].geometric_normal;
    const float most_m = settings.distance_relative * FILTER_POINTS[point].depth_m;
    const ivec2 here = ivec2(pixel % split.width, pixel / split.width);
    const ivec2 before = here - int(settings.width / 2);
    const ivec2 first = max(before, ivec2(0));
    const ivec2 end = min(before + int(settings.width), ivec2(split.width, split.height));
    float count = 1.0;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            if (ivec2(x, y) == here) continue;
            const uint neighbour = split_point_of(split, uint(x), uint(y));
            if (geometry_filter_takes(FILTER_POINTS[neighbour].kind) &&
                dot(normal, FILTER_POINTS[neighbour].normal) >= settings.normal_cosine &&
                abs(dot(plane, FILTER_POINTS[neighbour].position - position)) <= most_m) {
                sum += FILTER_IRRADIANCE[neighbour];
                count += 1.0;
            }
        }
    }
    return sum / count;
}

#endif
