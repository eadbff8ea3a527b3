// GLSL twin of transport/environment_sampling.cpp: an equirectangular environment, sampled by its radiance or by its
// radiance's excess over the mean.
#ifndef PHOTOND_ENVIRONMENT_SAMPLING_GLSL
#define PHOTOND_ENVIRONMENT_SAMPLING_GLSL

#include "renderer/core/angles.glsl"
#include "renderer/transport/light_tables.glsl"

layout(set = SCENE_SET, binding = ENVIRONMENT_BINDING, scalar) readonly buffer EnvironmentTexels {
    vec3 environment_texels[];
};

float environment_mean_radiance() { return NEEDS_ENVIRONMENT ? light_constants.environment_mean_radiance : 0.0; }

/// Cosine of the polar angle of a row's upper edge.
float environment_row_edge(uint row) { return light_floats[light_constants.row_edges + row]; }

/// Where the tables of an EnvironmentDensity are.
struct EnvironmentDensity {
    uint row_cdf, column_cdf;
};
EnvironmentDensity environment_by_radiance() {
    return EnvironmentDensity(light_constants.row_cdf, light_constants.column_cdf);
}
EnvironmentDensity environment_compensated() {
    return EnvironmentDensity(light_constants.compensated_row_cdf, light_constants.compensated_column_cdf);
}

uint environment_columns(EnvironmentDensity density, uint row) {
    return density.column_cdf + row * (light_constants.environment_width + 1u);
}

/// Share of all directions' density that a texel has.
float environment_probability(EnvironmentDensity density, uint column, uint row) {
    const uint rows = density.row_cdf + row, columns = environment_columns(density, row) + column;
    return (light_floats[rows + 1u] - light_floats[rows]) * (light_floats[columns + 1u] - light_floats[columns]);
}

/// The interval of a cumulative table that holds u, and where in it, in [0, 1).
uint find_interval(uint cdf, uint count, float u, out float within) {
    uint low = 1u, high = count;
    while (low < high) {
        const uint middle = (low + high) / 2u;
        if (light_floats[cdf + middle] <= u)
            low = middle + 1u;
        else
            high = middle;
    }
    const uint i = low - 1u;
    const float below = light_floats[cdf + i], share = light_floats[cdf + i + 1u] - below;
    within = share > 0.0 ? clamp((u - below) / share, 0.0, BELOW_ONE) : 0.5;
    return i;
}

/// (column, row) in [0, 1]^2.
vec2 environment_to_map(vec3 wi) {
    // Column centre at -z, columns running towards +x; turning the map counter-clockwise moves its columns back.
    float column = 0.5 + (atan2(wi.x, -wi.z) + light_constants.environment_rotation) / (2.0 * PI);
    column -= floor(column);
    // From the tangent: acos would lose half the digits near the poles.
    const float row = atan2(sqrt(wi.x * wi.x + wi.z * wi.z), wi.y) / PI;
    return vec2(min(column, BELOW_ONE), clamp(row, 0.0, BELOW_ONE));
}

bool environment_sample(EnvironmentDensity density, vec2 u, out vec3 wi, out float pdf_sa) {
    if (!(environment_mean_radiance() > 0.0)) return false;
    const uint width = light_constants.environment_width, height = light_constants.environment_height;
    float in_row, in_column;
    const uint y = find_interval(density.row_cdf, height, u.y, in_row);
    const uint x = find_interval(environment_columns(density, y), width, u.x, in_column);

    const float top = environment_row_edge(y), bottom = environment_row_edge(y + 1u);
    const float cos_polar = top + in_row * (bottom - top);
    const float sin_polar = sqrt(max(0.0, 1.0 - cos_polar * cos_polar));
    const vec2 azimuth =
        sin_cos(2.0 * PI * ((float(x) + in_column) / float(width) - 0.5) - light_constants.environment_rotation);
    wi = vec3(sin_polar * azimuth.x, cos_polar, -sin_polar * azimuth.y);
    pdf_sa = environment_probability(density, x, y) * float(width) / (2.0 * PI * (top - bottom));
    return pdf_sa > 0.0;
}

float environment_pdf(EnvironmentDensity density, vec3 wi) {
    if (!(environment_mean_radiance() > 0.0)) return 0.0;
    const uint width = light_constants.environment_width, height = light_constants.environment_height;
    const vec2 at = environment_to_map(wi);
    const uint y = min(uint(at.y * float(height)), height - 1u);
    const uint x = min(uint(at.x * float(width)), width - 1u);
    const float top = environment_row_edge(y), bottom = environment_row_edge(y + 1u);
    return environment_probability(density, x, y) * float(width) / (2.0 * PI * (top - bottom));
}

vec3 environment_texel(int column, int row) {
    const int width = int(light_constants.environment_width), height = int(light_constants.environment_height);
    column = column < 0 ? column + width : column >= width ? column - width : column;
    row = clamp(row, 0, height - 1);
    return environment_texels[uint(row) * uint(width) + uint(column)];
}

/// What arrives from outside the scene along -wi [W m^-2 sr^-1]; black without an environment.
vec3 environment_radiance(vec3 wi) {
    if (!NEEDS_ENVIRONMENT) return vec3(0.0);
    const vec2 at = environment_to_map(wi);
    const float x = at.x * float(light_constants.environment_width) - 0.5;
    const float y = at.y * float(light_constants.environment_height) - 0.5;
    const float fx = x - floor(x), fy = y - floor(y);
    const int x0 = int(floor(x)), y0 = int(floor(y));
    const vec3 above = (1.0 - fx) * environment_texel(x0, y0) + fx * environment_texel(x0 + 1, y0);
    const vec3 below = (1.0 - fx) * environment_texel(x0, y0 + 1) + fx * environment_texel(x0 + 1, y0 + 1);
    return light_constants.environment_scale * ((1.0 - fy) * above + fy * below);
}

#endif
