#pragma once
// Lighting a G-buffer by virtual point lights: E = sum I(w) cos_x / max(B, d^2) V [Sun 2015, equations 3.1 to
// 3.4], with the factor 1 / pi that the thesis leaves out. GPU twin: vpl_lighting_gpu.h.
//
// A point goes through its lights as many at once as the machine has lanes, looks what each would bring unshadowed, and
// asks for V where it counts.

#include "renderer/core/lanes.h"
#include "renderer/eye/eye_scene.h"
#include "renderer/gbuffer/gbuffer.h"
#include "renderer/many_lights/vpl_set.h"
#include "renderer/transport/bsdf_evaluator.h"
#include "renderer/voxels/svo_march.h"

namespace photond {

class SparseVoxelOctree;
class VplShadowMaps;

/// Who answers for V.
enum class VplVisibility : uint8_t {
    Svo,         // the voxels between: fast, wrong by about a voxel
    Rays,        // the scene
    ShadowMaps,  // a depth map a light
    None,        // all lights are seen
    /// The voxels within a radius about the point; what is farther stands in no light.
    /// [Thiedemann, Henrich, Grosch, Müller 2011] Voxel-based Global Illumination. I3D.
    NearField,
};
inline bool asks_voxels(VplVisibility visibility) {
    return visibility == VplVisibility::Svo || visibility == VplVisibility::NearField;
}

/// kLanes lights side by side; places past the end send nothing.
struct VplBlock {
    Vec3Array position, normal, intensity;
    alignas(kLaneAlignment) LaneFloats scatterings;
    uint32_t index[kLanes];  // in VplSet::vpls
    bool plain = true;       // Lambert, no correction

    /// `index`: the light's.
    void set(size_t lane, const Vpl& vpl, uint32_t light);
    /// Nothing is sent from there.
    void clear_from(size_t lane);
};

/// A light that a point asks, drawn by chance (vpl_choice.h).
struct ChosenVpl {
    uint32_t vpl;
    float weight;  // what it brings counts so many times
};

/// The lights of a pass in the subsets that tiles of the split buffer take: light i belongs to the tile t with
/// i = t + rotation modulo the number of tiles. With a random rotation each light is a tile's by a chance of one in so
/// many, whatever the lights' number: a subset's sum, times the number of tiles, has the mean of all.
class VplSubsets {
public:
    void assign(const VplSet& set, uint32_t tiles, uint32_t rotation);
    std::span<const VplBlock> of_tile(uint32_t tile) const {
        return std::span(blocks_).subspan(begins_[tile], begins_[tile + 1] - begins_[tile]);
    }
    uint64_t bytes() const { return blocks_.capacity() * sizeof(VplBlock); }

private:
    std::vector<VplBlock> blocks_;
    std::vector<uint32_t> begins_;
};

/// What all threads share in a pass. Borrows everything.
struct VplPass {
    const EyeScene& eye;
    const VplSet& set;
    const VplSubsets& subsets;
    VplVisibility visibility;
    const SparseVoxelOctree* tree;  // of Svo and NearField
    const VplShadowMaps* maps;      // of ShadowMaps
    float clamp_sq_m2;              // B; 0: none
    float roulette;                 // a light dimmer than that share of the mean is asked by chance; 0: all are
    uint64_t seed;
    uint32_t pass;
    float voxel_reach_m = kInfinity;  // voxels farther from a point do not stand in its light
};

/// Scratch of one thread.
class VplLighting {
public:
    /// Of the points [first, end), which are of one tile: irradiance [W m^-2] of Lambert points, radiance
    /// [W m^-2 sr^-1] before the throughput of others, is added to sums[first ...]. Shadow queries go to `counts`.
    void light(const VplPass& pass, const GBuffer& buffer, uint32_t first, uint32_t end, std::span<Rgb> sums,
               Counts& counts);
    /// The same of one point by those lights, dim ones by chance again.
    Rgb light_by(const VplPass& pass, const GBuffer& buffer, uint32_t point, std::span<const ChosenVpl> lights,
                 Counts& counts);
    /// What a point's random numbers of a pass are made of.
    static uint32_t key_of(const VplPass& pass, const gpu::GBufferPoint& point);

    /// What one light brings to the point unshadowed, by way of the same code: for choices of other kinds.
    struct Arriving {
        Vec3Array light;
        alignas(kLaneAlignment) LaneFloats size;  // its greatest component
    };
    /// Makes ready for a point, which all calls below are then about.
    void start_point(const VplPass& pass, const GBuffer& buffer, uint32_t point);
    /// What a block of lights brings to that point.
    Arriving arriving(const VplPass& pass, const VplBlock& block) const;
    /// Asks for V of a light, once trace() is called, and then adds `light` to the point's sum.
    void ask(const VplPass& pass, uint32_t vpl, const Rgb& light);
    Rgb trace(const VplPass& pass, Counts& counts);

private:
    void ask_by_chance(const VplPass& pass, uint32_t vpl, const Rgb& light, float size, float mean);

    struct Asked {
        uint32_t vpl;
        Rgb light;
    };

    const gpu::GBufferPoint* point_ = nullptr;
    const VisiblePoint* general_ = nullptr;
    std::optional<BsdfEvaluator> evaluator_;
    uint32_t key_ = 0;  // of the point's random numbers
    std::vector<Arriving> arriving_;
    std::vector<VplBlock> blocks_;  // of light_by()
    std::vector<Asked> asked_;
    std::vector<Ray> rays_;
    std::vector<SvoSegment> segments_;
    std::vector<uint8_t> occluded_;
};

}  // namespace photond
