// GLSL twin of core/geometry.h and core/rgb.h.
#ifndef PHOTOND_GEOMETRY_GLSL
#define PHOTOND_GEOMETRY_GLSL

const float PI = 3.14159265358979323846;
const float INV_PI = 0.31830988618379067154;
#define INFINITY uintBitsToFloat(0x7f800000u)
#define BELOW_ONE uintBitsToFloat(0x3f7fffffu)  // the greatest float below 1

struct Ray {
    vec3 origin;
    vec3 direction;  // unit length unless the user says so
    float t_max;
};

float sqr(float x) { return x * x; }

/// Relative luminance of Rec.709 primaries.
const vec3 LUMINANCE_WEIGHTS = vec3(0.2126, 0.7152, 0.0722);
float luminance(vec3 c) { return LUMINANCE_WEIGHTS.x * c.x + LUMINANCE_WEIGHTS.y * c.y + LUMINANCE_WEIGHTS.z * c.z; }
float max_component(vec3 c) { return max(max(c.x, c.y), c.z); }
float mean(vec3 c) { return (c.x + c.y + c.z) / 3.0; }
bool is_black(vec3 c) { return c.x == 0.0 && c.y == 0.0 && c.z == 0.0; }
bool is_finite(float x) { return !isnan(x) && !isinf(x); }
bool is_finite(vec3 c) { return is_finite(c.x) && is_finite(c.y) && is_finite(c.z); }

/// The magnitude of x with the sign of s, that of -0 too.
float copysign(float x, float s) {
    return uintBitsToFloat((floatBitsToUint(x) & 0x7fffffffu) | (floatBitsToUint(s) & 0x80000000u));
}

/// An orthonormal frame about a unit normal, without branches on its direction.
/// [Duff et al. 2017] Building an Orthonormal Basis, Revisited. JCGT 6(1).
struct Frame {
    vec3 tangent;
    vec3 bitangent;
    vec3 normal;
};

Frame make_frame(vec3 n) {
    const float s = copysign(1.0, n.z);
    const float a = -1.0 / (s + n.z);
    const float b = n.x * n.y * a;
    return Frame(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}
vec3 to_local(Frame frame, vec3 w) {
    return vec3(dot(w, frame.tangent), dot(w, frame.bitangent), dot(w, frame.normal));
}
vec3 to_world(Frame frame, vec3 w) { return w.x * frame.tangent + w.y * frame.bitangent + w.z * frame.normal; }

/// The point to start a ray from so that it does not meet the surface it leaves: `p` moved along `n` (unit, towards the
/// side the ray leaves to) by an amount scaled with the coordinates' own floating-point spacing.
/// [Waechter and Binder 2019] A Fast and Robust Method for Avoiding Self-Intersection. Ray Tracing Gems, ch. 6.
vec3 offset_ray_origin(vec3 p, vec3 n) {
    const float kOrigin = 1.0 / 32.0, kFloatScale = 1.0 / 65536.0, kIntScale = 256.0;
    const ivec3 offset = ivec3(kIntScale * n);
    const vec3 shifted = intBitsToFloat(floatBitsToInt(p) + mix(offset, -offset, lessThan(p, vec3(0.0))));
    return mix(shifted, p + kFloatScale * n, lessThan(abs(p), vec3(kOrigin)));
}

#endif
