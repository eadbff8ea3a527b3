#pragma once
// From the eye through what is specular: a tile's paths together, vertex by vertex. At each vertex light samples are
// drawn for the whole BSDF, the specular part f_s (delta lobes, and glossy ones with alpha below the threshold) is
// followed, and where there is a rough part f_d a visible point is left, for a method to bring it what light was
// scattered before. Light samples and followed directions are joined by multiple importance sampling.
//
// Plain Lambert reflectors are shaded in lanes (specular_walk_lambert.cpp): a path ends there, as there is no f_s.

#include <optional>
#include <span>
#include <vector>

#include "renderer/eye/eye_batch.h"
#include "renderer/eye/visible_point.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/light_seen.h"

namespace photond {

/// What a method decides at each vertex. The defaults: one light sample, judged by a shadow ray, that competes with the
/// followed direction alone.
struct WalkVertex {
    uint32_t light_samples = 1;  // at least 1, at most as many as there are samplers for them
    /// Other rays drawn by f_d that will meet lights: f_d's light samples are weighed by them.
    uint32_t competing_rays = 0;
};

/// Asked at each vertex with light samples, where a method has more to say than the defaults. One thread's.
class WalkGuide {
public:
    virtual ~WalkGuide() = default;
    /// `throughput` and `eta_scale` of the path up to the vertex; `waits`: a visible point is left there.
    virtual WalkVertex decide(const Rgb& throughput, float eta_scale, bool waits) const = 0;
    /// What is known of a light source (LightSample::source) at a point before any shadow ray is traced; `normal` is
    /// geometric, on the eye's side.
    virtual LightSeen light_seen(const vec3& position, const vec3& normal, uint32_t source) = 0;
};

/// Takes the visible points of a tile, vertex by vertex. One thread's.
class VisiblePointSink {
public:
    virtual ~VisiblePointSink() = default;
    /// Called for each vertex that left any; they are gone afterwards.
    virtual void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) = 0;
};

struct WalkSettings {
    float glossy_threshold = 0.05f;  // GGX lobes with alpha below it are specular
    WalkGuide* guide = nullptr;      // null: the defaults, at no cost
};

/// The numbers of one pass.
struct WalkSamplers {
    const PassSampler& path;                     // of camera, directions and roulette: one element
    std::span<const PassSampler> light_samples;  // of a vertex: one each; without a guide the first is used
};

/// Scratch of one thread; reused from tile to tile.
class SpecularWalk {
public:
    /// Most light samples of a vertex.
    static constexpr uint32_t kMostLightSamples = 4096;

    /// For tiles of at most `tile_side` by `tile_side` pixels.
    explicit SpecularWalk(uint32_t tile_side);
    static uint64_t bytes_per_thread(uint32_t tile_side);

    /// Walks the tile's paths of one pass. The tile's pixels of `image` are cleared and get what the walk finds: layers
    /// of the first hit, albedo, emitted, direct, and indirect (caustic among it) that came through specular parts; to
    /// `counts` and `seconds` is added. A visible point is left where f_d scatters and one more scattering, before it,
    /// is within EyeScene::max_scatterings. Cancelled: the pixels are unfinished.
    void trace_tile(const EyeScene& shared, const WalkSettings& settings, const WalkSamplers& samplers,
                    const Tile& tile, PassImage& image, Counts& counts, EyeSeconds& seconds, const CancelToken& cancel,
                    VisiblePointSink& sink);

    /// The path that ends at the point, and its key of the sampler. Within VisiblePointSink::take() alone.
    const EyePath& path(const LambertVisiblePoint& point) const { return batch_.former_path(point.path); }
    uint32_t path_key(const LambertVisiblePoint& point) const { return batch_.former_key(point.path); }
    /// The point with the general form's BSDF and surface, as far as lookups ask for them. Within take() alone.
    VisiblePoint general(const LambertVisiblePoint& point) const;
    /// Number of the vertex whose points are being handed over; 0 is the first.
    uint32_t vertex() const { return vertex_; }

private:
    /// What every step needs.
    struct Pass {
        const EyeScene& shared;
        const WalkSettings& settings;
        const WalkSamplers& samplers;
        PassImage& image;
        Counts& counts;
    };
    /// Where light samples are drawn, for one or all of them.
    struct LitPoint {
        vec3 position;          // world, as the normals are
        vec3 geometric_normal;  // on the eye's side
        vec3 lit_normal;        // for the light sampler
        uint32_t index;         // of the path
        uint32_t pixel;
        bool indirect;
        // What the guide said of the last light: it is the same for each of its samples.
        std::optional<uint32_t> judged{};
        LightSeen seen = LightSeen::Unknown;
    };

    void draw_numbers(const Pass& pass);
    void shade_lambert(const Pass& pass);
    void light_lambert(const Pass& pass, const LambertGroup& group, size_t lane, uint32_t i, const Rgb& weight);
    void shade_general(const Pass& pass);
    bool shade_vertex(const Pass& pass, uint32_t i);
    WalkVertex decide(const Pass& pass, const EyePath& path, bool waits);
    bool draw_light(const Pass& pass, const LitPoint& point, uint32_t sample, LightSample& light) const;
    void add_light(const Pass& pass, LitPoint& point, const LightSample& light, const vec3& origin,
                   const Rgb& radiance);
    void trace_shadow_rays(const Pass& pass);

    uint32_t vertex_ = 0;
    EyeBatch batch_;
    std::vector<LambertVisiblePoint> lambert_points_;  // of this vertex
    std::vector<VisiblePoint> points_;
    PathNumbers light_point_, light_choice_, roulette_, direction_, lobe_;
    ShadowBatch<WaitingLight> shadows_;
};

}  // namespace photond
