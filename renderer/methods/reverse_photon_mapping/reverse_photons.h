#pragma once
// Reverse photons: ends of gather rays that wait for photons to stream past them.
//
// A thread keeps those of its rays until it has a tile full. They are sorted by cell, side and place in the cell, cut
// into groups of neighbours, and photons near a group are sought once for all of its points. Then one photon after the
// other is compared with eight points at a time. Every point sums its photons in the order of their cells, whatever the
// other points of its group are, and pixels sum their points in the order in which they were added: the image does not
// depend on the size of tiles, nor on threads.
//
// Lambert reflectors, which scatter the same share of all photons, are summed in lanes of points. For other surfaces
// the photons that lie on a point's disc are picked out, and what they scatter is summed in lanes of photons
// (disc_photons.h).

#include <optional>
#include <span>
#include <vector>

#include "renderer/gathering/photon_lookup.h"
#include "renderer/methods/reverse_photon_mapping/photon_stream.h"
#include "renderer/photons/point_bucket.h"

namespace photond {

/// The streams of a pass; empty where there is no such map.
struct PassStreams {
    PhotonStream global, caustic;
};

/// What the pixels are brought, apart from what else their passes find: tiles end at no fixed time.
struct StreamedImage {
    std::vector<Rgb> indirect;
    std::vector<float> photons;  // layer photon_count; empty when nobody asks for it
};

/// What the reverse photons of all threads share; all is borrowed.
struct ReversePass {
    const GatheringScene& shared;
    const PassMaps& maps;
    const PassStreams& streams;
    StreamedImage& image;
    const CancelToken& cancel;
};

/// One thread's tile.
class ReversePhotons final : public RayEndLookups {
public:
    /// Room for so many points.
    explicit ReversePhotons(uint32_t most_points);
    static uint64_t bytes_for(uint32_t most_points);

    /// Those that are added belong to this pass; nothing of another one is left.
    void start(const ReversePass& pass);
    /// Streams when the tile is full. Where an edge may cut the disc (`boundary`: clip) the maps are looked up at once.
    bool add(const RayEnd& end, PassImage& image) override;
    /// Streams the photons past the points that wait, and adds what they bring.
    void stream();

private:
    /// A point that waits. `kind`: kFlat, a Lambert reflector; kSmooth, one whose normal that shades is not the
    /// geometric one; else its index among others.
    struct Point {
        vec3 position;
        vec3 normal;  // geometric
        vec3 shading_normal;
        Rgb weight;  // what Sum::light brings to the pixel
        uint32_t pixel;
        float most_scatterings;
        uint32_t kind;
        bool global;  // whether the global map's light is wanted, beside the caustic map's
    };
    static constexpr uint32_t kFlat = UINT32_MAX, kSmooth = UINT32_MAX - 1;
    struct Other {
        Bsdf rough;
        vec3 wo;  // local to Frame(shading_normal)
    };
    struct Sum {
        Rgb light{0};  // at a Lambert reflector irradiance [W m^-2], else radiance [W m^-2 sr^-1]
        float photons = 0;
    };
    struct Keyed {
        uint64_t key;
        uint32_t point;
    };
    /// What is asked of a photon first, close together.
    struct NearPhoton {
        vec3 position;
        float radius_sq_m2;
        Rgb power_over_area;
        uint32_t entry;  // of the octave, and whether there is more to ask
    };
    struct Lanes;
    struct Group;

    void sort_points();
    void stream_past(const Group& group, const PhotonStream& stream, bool global);
    void sift(const Group& group, const PhotonStream::Octave& octave, bool unlimited);
    template <bool kPlain, bool kSmooth>
    void sum_lambert(const Lanes& lanes, const PhotonStream::Octave& octave, bool global);
    void sum_others(const Group& group, const PhotonStream::Octave& octave, bool global);
    void add_to_pixels();

    std::optional<ReversePass> pass_;
    std::optional<SearchedRayEnds> searched_ends_;
    const size_t most_points_, most_others_;
    std::vector<Point> points_;
    std::vector<Other> others_;
    std::vector<Sum> sums_;
    std::vector<Keyed> order_, order_scratch_;
    std::vector<uint32_t> near_indices_;  // photons of an octave about a group
    std::vector<NearPhoton> near_;        // of these those that some point wants
    static constexpr uint32_t kBucket = 16;
    std::vector<PointBucket<kBucket>> near_places_;
    std::vector<uint32_t> hits_;  // of these those about one point
    std::vector<float> hit_distances_sq_;
};

}  // namespace photond
