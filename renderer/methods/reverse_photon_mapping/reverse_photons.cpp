#include "renderer/methods/reverse_photon_mapping/reverse_photons.h"

#include <algorithm>
#include <array>

#include "renderer/core/morton.h"
#include "renderer/methods/reverse_photon_mapping/point_lanes.h"
#include "renderer/photons/disc_photons.h"

namespace photond {

namespace {

/// Points that photons are sought for together, at most. From 64 to 512, and in cells of 0.5 to 2 radii, times differ
/// by less than what they vary by.
constexpr size_t kMostInGroup = 128;
static_assert(kMostInGroup % point_lanes::kCount == 0);

// What is certain of a group's points by the normal of the first alone. Normals nearer to it than this cosine ...
constexpr float kLikeNormal = 0.9999f;
// ... are within this sine of it, and cosines to any other vector of length one differ by less.
constexpr float kNormalSpread = 0.0145f;

/// Scatterings that no photon has more of.
constexpr auto kUnlimited = static_cast<float>(PhotonPayload::kMostScatterings);

/// Of an entry of the photons near a group: whether each point is to ask for itself if the photon lies on its disc.
constexpr uint32_t kAsk = 1u << 31;

/// Keys are sorted by their lowest `bits` bits; the order of equal ones stays.
template <class Keyed>
void radix_sort(std::vector<Keyed>& keyed, std::vector<Keyed>& scratch, uint32_t bits) {
    constexpr uint32_t kDigit = 11;
    scratch.resize(keyed.size());
    std::array<uint32_t, 1u << kDigit> starts;
    for (uint32_t shift = 0; shift < bits; shift += kDigit) {
        const auto digit = [&](const Keyed& k) { return k.key >> shift & ((1u << kDigit) - 1); };
        starts.fill(0);
        for (const Keyed& k : keyed) ++starts[digit(k)];
        uint32_t sum = 0;
        for (uint32_t& start : starts) sum += std::exchange(start, sum);
        for (const Keyed& k : keyed) scratch[starts[digit(k)]++] = k;
        keyed.swap(scratch);
    }
}

float scatterings_of(uint32_t normal_and_path) {
    return static_cast<float>(PhotonPayload{.normal_and_path = normal_and_path}.scatterings());
}

point_lanes::Floats kernel_of(const Kernel& kernel, const point_lanes::Floats& q_sq) {
    static_assert(sizeof(FloatLanes) == sizeof q_sq);
    FloatLanes lanes;
    __builtin_memcpy(static_cast<void*>(&lanes), &q_sq, sizeof q_sq);
    lanes = kernel(min(lanes, FloatLanes(1)));
    point_lanes::Floats weights;
    __builtin_memcpy(&weights, static_cast<const void*>(&lanes), sizeof weights);
    return weights;
}

/// Sums what photons that lie on a point's disc scatter towards the eye: as ScatteredSum, of photons made ready.
class StreamedSum {
public:
    StreamedSum(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wo)
        : point_(point, bsdf, wo), normal_code_(Octahedral<11>::encode(point.geometric_normal)) {}

    /// `power`: times the kernel, over the disc's radius squared.
    void add(const StreamedDirection& direction, uint32_t normal_and_path, const Rgb& power, float side) {
        // Most photons have the very normal of the point, which is known better than its code.
        const bool same = (normal_and_path & PHOTON_NORMAL_BITS) == normal_code_;
        cosine_[size_] = same ? glm::dot(direction.wi, point_.normal()) : direction.cosine;
        for (int c = 0; c < 3; ++c) wi_[static_cast<size_t>(c)][size_] = direction.wi[c];
        for (int c = 0; c < 3; ++c) power_[static_cast<size_t>(c)][size_] = power[c];
        side_[size_] = side;
        if (++size_ == kLanes) flush();
    }
    Rgb finish() {
        for (size_t lane = size_; lane < kLanes && size_ > 0; ++lane) {
            for (auto& colour : power_) colour[lane] = 0;
            for (auto& coordinate : wi_) coordinate[lane] = coordinate[0];
            cosine_[lane] = side_[lane] = 1;
        }
        if (size_ > 0) flush();
        return {reduce(sum_.x), reduce(sum_.y), reduce(sum_.z)};
    }

private:
    using Lanes = std::array<float, kLanes>;
    static FloatLanes load(const Lanes& v) { return FloatLanes(v.data(), std::experimental::element_aligned); }
    void flush() {
        sum_ = sum_ + point_.reflected({load(wi_[0]), load(wi_[1]), load(wi_[2])}, load(side_), load(cosine_),
                                       {load(power_[0]), load(power_[1]), load(power_[2])});
        size_ = 0;
    }

    const PointScattering point_;
    const uint32_t normal_code_;
    size_t size_ = 0;
    std::array<Lanes, 3> wi_, power_;
    Lanes cosine_, side_;
    Vec3Lanes sum_{0, 0, 0};
};

/// 0 ... 5: the axis that a normal is nearest to.
uint64_t side_of(const vec3& normal) {
    const vec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return static_cast<uint64_t>(2 * axis + (normal[axis] < 0 ? 1 : 0));
}

}  // namespace

/// Lambert reflectors of a group, side by side; lanes without a point lie at infinity.
struct ReversePhotons::Lanes {
    using Floats = std::array<float, kMostInGroup>;
    size_t count = 0;
    alignas(64) Floats x, y, z, normal_x, normal_y, normal_z, shading_x, shading_y, shading_z;
    alignas(64) Floats most_scatterings, most_of_global;
    alignas(64) std::array<int32_t, kMostInGroup> normal_code;  // PHOTON_NORMAL_BITS
    std::array<uint32_t, kMostInGroup> point;

    void add(const Point& p, uint32_t index) {
        const size_t i = count++;
        x[i] = p.position.x, y[i] = p.position.y, z[i] = p.position.z;
        normal_x[i] = p.normal.x, normal_y[i] = p.normal.y, normal_z[i] = p.normal.z;
        shading_x[i] = p.shading_normal.x, shading_y[i] = p.shading_normal.y, shading_z[i] = p.shading_normal.z;
        most_scatterings[i] = p.most_scatterings;
        most_of_global[i] = p.global ? p.most_scatterings : -1.0f;
        if (p.kind == kSmooth) normal_code[i] = static_cast<int32_t>(Octahedral<11>::encode(p.normal));
        point[i] = index;
    }
    void fill() {
        for (size_t i = count; i % point_lanes::kCount != 0; ++i) {
            x[i] = y[i] = z[i] = kInfinity;
            normal_x[i] = normal_y[i] = normal_z[i] = shading_x[i] = shading_y[i] = shading_z[i] = 0;
            most_scatterings[i] = most_of_global[i] = -1;
            normal_code[i] = 0;
        }
    }
    const Floats& most(bool global) const { return global ? most_of_global : most_scatterings; }
    bool unlimited(bool global) const {
        return std::all_of(most(global).begin(), most(global).begin() + static_cast<std::ptrdiff_t>(count),
                           [](float scatterings) { return scatterings >= kUnlimited; });
    }
};

/// Neighbours among the sorted points.
struct ReversePhotons::Group {
    Bounds3 box;
    vec3 first{0};             // of the points
    vec3 normal{0};            // its
    uint32_t normal_code = 0;  // PHOTON_NORMAL_BITS
    bool like_normal = true;   // all are as good as it
    bool both_sides = false;   // of some point photons count on either side
    float spread_m = 0;        // of the points about the plane of the first
    Lanes flat, smooth;
    size_t others = 0;
    bool others_unlimited = true;
    std::array<uint32_t, kMostInGroup> other;

    void start(const Point& p) {
        box = Bounds3();
        first = p.position, normal = p.normal;
        normal_code = Octahedral<11>::encode(normal);
        like_normal = others_unlimited = true, both_sides = false;
        spread_m = 0;
        flat.count = smooth.count = others = 0;
    }
    void add(const Point& p, uint32_t index) {
        like_normal = like_normal && glm::dot(p.normal, normal) >= kLikeNormal;
        spread_m = std::max(spread_m, std::fabs(glm::dot(p.position - first, normal)));
        if (p.kind == kFlat) {
            flat.add(p, index);
        } else if (p.kind == kSmooth) {
            smooth.add(p, index);
        } else {
            other[others++] = index;
            others_unlimited = others_unlimited && p.most_scatterings >= kUnlimited;
        }
    }
};

ReversePhotons::ReversePhotons(uint32_t most_points) : most_points_(most_points), most_others_(most_points / 4) {
    points_.reserve(most_points_);
    others_.reserve(most_others_);
    sums_.reserve(most_points_);
    order_.reserve(most_points_);
    order_scratch_.reserve(most_points_);
}

uint64_t ReversePhotons::bytes_for(uint32_t most_points) {
    return most_points * (sizeof(Point) + sizeof(Sum) + 2 * sizeof(Keyed)) + most_points / 4 * sizeof(Other);
}

void ReversePhotons::start(const ReversePass& pass) {
    pass_.emplace(pass);
    searched_ends_.emplace(pass.shared, pass.maps);
    points_.clear();
    others_.clear();
}

bool ReversePhotons::add(const RayEnd& end, PassImage& image) {
    const auto& [surface, rough, wo, to_pixel, pixel, most, turn, most_radius_m] = end;
    const auto& [shared, maps, streams, streamed, cancel] = *pass_;
    if (most == 0 || !rough.has_non_delta() || (streams.global.empty() && streams.caustic.empty())) return true;
    if (shared.coverage && shared.coverage->may_be_cut(surface.position, shared.search_radius_m))
        return searched_ends_->add(end, image);

    const bool flat = rough.is_lambert() && surface.shading.normal == surface.geometric_normal;
    if (flat && wo.z <= 0) return true;
    bool global = !streams.global.empty(), goes_on = false;
    if (global && most_radius_m < shared.search_radius_m &&
        streams.global.radius_at_m(surface.position, shared.search_radius_m) > most_radius_m) {
        global = false;
        goes_on = true;
    }
    if (!global && streams.caustic.empty()) return !goes_on;

    Point point{.position = surface.position,
                .normal = surface.geometric_normal,
                .shading_normal = surface.shading.normal,
                .weight = to_pixel,
                .pixel = pixel,
                .most_scatterings = static_cast<float>(std::min(most, PhotonPayload::kMostScatterings)),
                .kind = flat ? kFlat : kSmooth,
                .global = global};
    if (rough.is_lambert()) {
        point.weight *= rough.f_cos(wo, vec3(0, 0, 1));
    } else {
        point.kind = static_cast<uint32_t>(others_.size());
        others_.push_back({rough, wo});
    }
    points_.push_back(point);
    if (points_.size() == most_points_ || others_.size() == most_others_) stream();
    return !goes_on;
}

void ReversePhotons::sort_points() {
    const auto& [shared, maps, streams, streamed, cancel] = *pass_;
    const float cell_m = (streams.global.empty() ? streams.caustic : streams.global).typical_radius_m();
    Bounds3 bounds;
    for (const Point& p : points_) bounds.extend(p.position);
    constexpr float kMostCell = 0xffff;
    const vec3 extent = bounds.diagonal();
    const float most_cells = std::min(max_component(extent) / cell_m, kMostCell);
    const auto axis_bits = static_cast<uint32_t>(std::bit_width(static_cast<uint32_t>(most_cells)));
    order_.resize(points_.size());
    for (uint32_t i = 0; i < points_.size(); ++i) {
        const vec3 place = (points_[i].position - bounds.min) / cell_m;
        const vec3 cell = glm::min(glm::floor(place), kMostCell);
        const uvec3 within(glm::clamp((place - cell) * 4.0f, 0.0f, 3.0f));
        order_[i] = {morton_code_wide(uvec3(cell)) << 9 | side_of(points_[i].normal) << 6 | morton_code(within), i};
    }
    radix_sort(order_, order_scratch_, 3 * axis_bits + 9);
}

void ReversePhotons::stream() {
    if (points_.empty()) return;
    const auto& [shared, maps, streams, streamed, cancel] = *pass_;
    sums_.assign(points_.size(), {});
    sort_points();
    const float cell_m = (streams.global.empty() ? streams.caustic : streams.global).typical_radius_m();
    Group group;
    for (size_t first = 0; first < order_.size() && !cancel.cancelled();) {
        const Point& start = points_[order_[first].point];
        group.start(start);
        size_t i = first;
        for (; i < order_.size() && i - first < kMostInGroup; ++i) {
            if (i + 8 < order_.size()) __builtin_prefetch(&points_[order_[i + 8].point]);
            const Point& point = points_[order_[i].point];
            Bounds3 box = group.box;
            box.extend(point.position);
            if (i > first && max_component(box.diagonal()) > cell_m) break;
            group.box = box;
            if (point.kind < kSmooth && others_[point.kind].rough.has_non_delta_transmission()) group.both_sides = true;
            group.add(point, order_[i].point);
        }
        first = i;
        group.flat.fill();
        group.smooth.fill();
        if (!streams.global.empty()) stream_past(group, streams.global, true);
        if (!streams.caustic.empty()) stream_past(group, streams.caustic, false);
    }
    if (!cancel.cancelled()) add_to_pixels();
    points_.clear();
    others_.clear();
}

/// The photons of an octave near a group, one beside the other: what no point wants is left out, and what all want need
/// not be asked.
void ReversePhotons::sift(const Group& group, const PhotonStream::Octave& octave, bool unlimited) {
    const bool certain = group.like_normal && !pass_->shared.estimate.soft_disc;
    // A height over another point's plane differs by so much, that plane being tilted.
    const float slack_m = group.spread_m + kNormalSpread * octave.radius_m;
    near_.resize(near_indices_.size());
    size_t kept = 0;
    for (const uint32_t index : near_indices_) {
        const StreamedPhoton& photon = octave.photons[index];
        // Most photons have the normal of the points: no need to look that up.
        const bool same = (photon.normal_and_path & PHOTON_NORMAL_BITS) == group.normal_code;
        const float side = same ? 1.0f : glm::dot(octave.directions[index].normal, group.normal);
        const float height_m = std::fabs(glm::dot(photon.position - group.first, group.normal));
        const bool never = certain && ((group.both_sides ? std::fabs(side) : side) < kDiscCosine - kNormalSpread ||
                                       height_m > octave.most_thickness_m + slack_m);
        const bool always =
            certain && unlimited && side > kDiscCosine + kNormalSpread && height_m + slack_m < octave.least_thickness_m;
        near_[kept] = {photon.position, photon.radius_sq_m2, photon.power_over_area, index | (always ? 0 : kAsk)};
        kept += !never;
    }
    near_.resize(kept);
}

void ReversePhotons::stream_past(const Group& group, const PhotonStream& stream, bool global) {
    const EstimateSettings& settings = pass_->shared.estimate;
    const bool plain = settings.kernel.shape() == KernelShape::Constant && !settings.soft_disc;
    const bool unlimited = group.flat.unlimited(global) && group.smooth.unlimited(global) && group.others_unlimited;
    for (const PhotonStream::Octave& octave : stream.octaves()) {
        near_indices_.clear();
        octave.grid->find_near_box(group.box, octave.radius_m, near_indices_);
        sift(group, octave, unlimited);
        if (near_.empty()) continue;
        if (plain) {
            sum_lambert<true, false>(group.flat, octave, global);
            sum_lambert<true, true>(group.smooth, octave, global);
        } else {
            sum_lambert<false, false>(group.flat, octave, global);
            sum_lambert<false, true>(group.smooth, octave, global);
        }
        if (group.others > 0) sum_others(group, octave, global);
    }
}

/// One photon after the other past eight Lambert reflectors. `kPlain`: the kernel is constant, and no disc soft.
/// `kSmooth`: the normals that shade are not the geometric ones.
template <bool kPlain, bool kSmooth>
void ReversePhotons::sum_lambert(const Lanes& lanes, const PhotonStream::Octave& octave, bool global) {
    using namespace point_lanes;
    const EstimateSettings& settings = pass_->shared.estimate;
    const float least_cosine = settings.soft_disc ? 0 : kDiscCosine;
    for (size_t first = 0; first < lanes.count; first += kCount) {
        const Vec3s position{load(&lanes.x[first]), load(&lanes.y[first]), load(&lanes.z[first])};
        const Vec3s normal{load(&lanes.normal_x[first]), load(&lanes.normal_y[first]), load(&lanes.normal_z[first])};
        const Vec3s shading{load(&lanes.shading_x[first]), load(&lanes.shading_y[first]),
                            load(&lanes.shading_z[first])};
        const Floats most = load(&lanes.most(global)[first]);
        const Ints code = load(&lanes.normal_code[first]);
        Vec3s sum{};
        Ints photons{};
        for (const NearPhoton& near : near_) {
            const Vec3s to_point{position.x - near.position.x, position.y - near.position.y,
                                 position.z - near.position.z};
            const Floats distance_sq = distances_sq(to_point);
            Ints on = distance_sq < near.radius_sq_m2;
            Floats weight = Floats{} + 1;
            if (!kPlain || kSmooth || (near.entry & kAsk)) {
                if (!any(on)) continue;
                const uint32_t index = near.entry & ~kAsk;
                const StreamedDirection& direction = octave.directions[index];
                const uint32_t normal_and_path = octave.photons[index].normal_and_path;
                if (near.entry & kAsk) {
                    const Floats height_m = absolute(dot(normal, to_point)), side = dot(normal, direction.normal);
                    on &= (height_m <= direction.thickness_m) & (side >= least_cosine) &
                          (most >= scatterings_of(normal_and_path));
                    if (!kPlain && settings.soft_disc) {
                        on &= side > 0;
                        weight = direction.thickness_m > 0 ? side * (1 - height_m / direction.thickness_m) : side;
                    }
                }
                photons -= on;
                if constexpr (!kPlain) weight *= kernel_of(settings.kernel, distance_sq / near.radius_sq_m2);
                if constexpr (kSmooth) {
                    // As ScatteredSum has it.
                    const Floats cos_shading = dot(shading, direction.wi), cos_own = dot(normal, direction.wi);
                    const Ints same = code == static_cast<int32_t>(normal_and_path & PHOTON_NORMAL_BITS);
                    const Floats cos_photon = absolute(same ? cos_own : Floats{} + direction.cosine);
                    on &= (cos_shading > 0) & (cos_own > 0);
                    weight *= cos_shading / (cos_photon > kLeastCosine ? cos_photon : Floats{} + kLeastCosine);
                }
            } else {
                photons -= on;  // without a branch: which are near is chance
            }
            sum.x += keep(on, weight * near.power_over_area.x);
            sum.y += keep(on, weight * near.power_over_area.y);
            sum.z += keep(on, weight * near.power_over_area.z);
        }
        const float scale = kPlain ? settings.kernel(0) : 1.0f;
        for (size_t lane = 0; lane < std::min(kCount, lanes.count - first); ++lane) {
            Sum& of_point = sums_[lanes.point[first + lane]];
            of_point.light += scale * Rgb(sum.x[lane], sum.y[lane], sum.z[lane]);
            of_point.photons += static_cast<float>(photons[lane]);
        }
    }
}

/// Points that are no Lambert reflectors, one after the other past the photons.
void ReversePhotons::sum_others(const Group& group, const PhotonStream::Octave& octave, bool global) {
    const EstimateSettings& settings = pass_->shared.estimate;
    const bool constant = settings.kernel.shape() == KernelShape::Constant;
    const size_t buckets = (near_.size() + kBucket - 1) / kBucket;
    near_places_.resize(buckets);
    for (uint32_t i = 0; i < buckets * kBucket; ++i)
        near_places_[i / kBucket].set(i % kBucket, i < near_.size() ? near_[i].position : vec3(kInfinity));
    hits_.resize(buckets * kBucket), hit_distances_sq_.resize(buckets * kBucket);
    for (const uint32_t index : std::span(group.other).first(group.others)) {
        const Point& point = points_[index];
        if (global && !point.global) continue;
        uint32_t hits = 0;
        for (uint32_t b = 0; b < buckets; ++b)
            hits += near_places_[b].append_nearer(point.position, sqr(octave.radius_m), b * kBucket,
                                                  &hit_distances_sq_[hits], &hits_[hits]);
        if (hits == 0) continue;
        const Other& other = others_[point.kind];
        ShadingPoint surface;
        surface.position = point.position;
        surface.geometric_normal = point.normal;
        surface.shading = Frame(point.shading_normal);
        const Disc disc{point.position,
                        point.normal,
                        other.rough.has_non_delta_transmission(),
                        static_cast<uint32_t>(point.most_scatterings),
                        {}};
        const DiscTest test(settings, disc, 0);
        StreamedSum scattered(surface, other.rough, other.wo);
        Sum& sum = sums_[index];
        for (uint32_t h = 0; h < hits; ++h) {
            const NearPhoton& near = near_[hits_[h]];
            if (!(hit_distances_sq_[h] < near.radius_sq_m2)) continue;
            const uint32_t place = near.entry & ~kAsk;
            const StreamedDirection& direction = octave.directions[place];
            const uint32_t normal_and_path = octave.photons[place].normal_and_path;
            float weight = constant ? settings.kernel(0) : settings.kernel(hit_distances_sq_[h] / near.radius_sq_m2);
            float side = 1;
            if (near.entry & kAsk) {
                const float height_m = test.height_m(near.position), thickness_m = direction.thickness_m;
                side = test.side(normal_and_path, height_m, thickness_m, [&] { return direction.normal; });
                if (side == 0) continue;
                if (settings.soft_disc)
                    weight *= std::fabs(side) * (thickness_m > 0 ? 1 - height_m / thickness_m : 1.0f);
            }
            scattered.add(direction, normal_and_path, weight * near.power_over_area, side);
            sum.photons += 1;
        }
        sum.light += scattered.finish();
    }
}

void ReversePhotons::add_to_pixels() {
    StreamedImage& image = pass_->image;
    for (size_t i = 0; i < points_.size(); ++i) {
        image.indirect[points_[i].pixel] += points_[i].weight * sums_[i].light;
        if (!image.photons.empty()) image.photons[points_[i].pixel] += sums_[i].photons;
    }
}

}  // namespace photond
