#pragma once
// One photon: light that arrived at a surface. The record is that of [Jensen 1996], with the surface normal beside it.
//
// [Jensen 1996] Global Illumination using Photon Maps. Eurographics Workshop on Rendering.

#include "renderer/core/rgb.h"
#include "renderer/core/rng.h"
#include "renderer/photons/photon_shared.h"

namespace photond {

/// A unit vector in 2 x `kBits` bits: the octahedral map. [Cigolle et al. 2014] A Survey of Efficient Representations
/// for Independent Unit Vectors. JCGT 3(2). Error with 16 bits below 7e-5 rad, with 11 bits below 2.1e-3 rad.
template <uint32_t kBits>
struct Octahedral {
    static constexpr uint32_t kMask = (1u << kBits) - 1;

    static uint32_t encode(const vec3& n) {
        const float scale = 1 / (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z));
        vec2 p = vec2(n.x, n.y) * scale;
        if (n.z < 0) {
            p = vec2((1 - std::fabs(p.y)) * std::copysign(1.0f, p.x), (1 - std::fabs(p.x)) * std::copysign(1.0f, p.y));
        }
        return code(p.x) | code(p.y) << kBits;
    }
    static vec3 decode(uint32_t bits) {
        const vec2 p(coordinate(bits & kMask), coordinate(bits >> kBits & kMask));
        vec3 n(p.x, p.y, 1 - std::fabs(p.x) - std::fabs(p.y));
        if (n.z < 0) {
            n.x = (1 - std::fabs(p.y)) * std::copysign(1.0f, p.x);
            n.y = (1 - std::fabs(p.x)) * std::copysign(1.0f, p.y);
        }
        return n * (1 / std::sqrt(glm::dot(n, n)));
    }

private:
    // Codes 0 ... 2^kBits - 2, so that 0 is met exactly: axis-aligned normals, the commonest, come back as they were.
    static uint32_t code(float x) {  // to the nearest
        constexpr float kHalf = 0.5f * static_cast<float>(kMask - 1);
        return static_cast<uint32_t>(x * kHalf + (kHalf + 0.5f));
    }
    static float coordinate(uint32_t code) { return 2 * static_cast<float>(code) / static_cast<float>(kMask - 1) - 1; }
};

/// What is stored of a photon besides its place.
struct PhotonPayload {
    Rgb power_w{0};          // flux [W], already divided by the number of light paths EMITTED
    uint32_t direction = 0;  // Octahedral<16>: from the surface towards where the light came from
    uint32_t normal_and_path = 0;

    static constexpr uint32_t kMostScatterings = 255;  // more count as so many

    /// `normal`: geometric, on the side the photon arrived at. `all_delta`: every scattering on the way was a delta
    /// lobe's; true without any. `marked`: is_marked_photon().
    static PhotonPayload make(const Rgb& power_w, const vec3& wi_world, const vec3& normal, uint32_t scatterings,
                              bool all_delta, bool marked = false) {
        const uint32_t path =
            std::min(scatterings, kMostScatterings) | (all_delta ? 1u << 8 : 0u) | (marked ? 1u << 9 : 0u);
        return {power_w, Octahedral<16>::encode(wi_world), Octahedral<11>::encode(normal) | path << 22};
    }
    vec3 wi_world() const { return Octahedral<16>::decode(direction); }
    vec3 normal() const { return Octahedral<11>::decode(normal_and_path); }
    /// Scatterings since the light, 0: it came from the light straight.
    uint32_t scatterings() const { return normal_and_path >> 22 & 0xffu; }
    bool all_delta() const { return normal_and_path >> 30 & 1u; }
    bool marked() const { return normal_and_path >> 31; }
};

/// Whether the photon that the path with this element of the sequence leaves after so many scatterings is one of those
/// where irradiance may be worked out beforehand (precomputed_irradiance.h): one of PHOTONS_A_MARK, at random, and the
/// same ones on all devices.
constexpr bool is_marked_photon(uint64_t element, uint32_t scatterings) {
    return hash32(hash32(static_cast<uint32_t>(element)) + scatterings) % PHOTONS_A_MARK == 0;
}

struct Photon {
    vec3 position;  // world [m], on the surface
    PhotonPayload payload;
};
static_assert(sizeof(Photon) == 32, "photons fill the memory: 32 bytes each");

}  // namespace photond
