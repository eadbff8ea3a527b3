#include "renderer/many_lights/incremental_vpls.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <queue>

#include "protocol/error.h"
#include "renderer/core/copy_elements.h"
#include "renderer/core/parallel.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kPathsMagic = 0x534c5056, kPathsVersion = 1;  // "VPLS"
/// A path meets its surface again within that share of the way there: what comes nearer to the lamp hides it.
constexpr float kMeets = 0x1p-10f;
/// Where two shares together are below that share of an even one, lights are crowded.
constexpr double kCrowded = 1;

struct PathsHead {
    uint32_t magic, version, slots, lights, paths;
    uint32_t unused;
    uint64_t seed;
};

/// A path on its way to being chosen.
struct CandidatePath {
    LeftVplPath left;
    ChosenStart start;  // with all of its texel's power
    float flux_w = 0;   // that its first hit reflects of that
    double place = 0;   // share of the map's flux that comes before it
};

/// The flux that a map reflects, along its curve.
class FluxCurve {
public:
    explicit FluxCurve(const FluxMap& flux) : before_w_(flux.texels() + 1) {
        for (uint32_t i = 0; i < flux.texels(); ++i) before_w_[i + 1] = before_w_[i] + double{flux.worth()[i]};
    }
    double total_w() const { return before_w_.back(); }
    /// The share of the flux before a place (TexelMapPass::curve_place()).
    double share_before(uint64_t curve_place) const {
        const uint64_t texel = curve_place >> TexelMapPass::kPlaceBits;
        constexpr uint64_t kTexel = uint64_t{1} << TexelMapPass::kPlaceBits;
        const double within = static_cast<double>(curve_place & (kTexel - 1)) / static_cast<double>(kTexel);
        return (before_w_[texel] + within * (before_w_[texel + 1] - before_w_[texel])) / total_w();
    }
    /// The texel at that share, which reflects something.
    uint32_t texel_at(double share) const {
        const auto found = std::upper_bound(before_w_.begin(), before_w_.end(), share * total_w());
        if (found != before_w_.end()) return static_cast<uint32_t>(found - before_w_.begin()) - 1;
        return static_cast<uint32_t>(std::lower_bound(before_w_.begin(), before_w_.end(), total_w()) -
                                     before_w_.begin()) -
               1;
    }

private:
    std::vector<double> before_w_;
};

/// Finds the first hits of all, and what they reflect. `keep(path, hit)`: whether that is what it is to meet.
template <class Keep>
void look_along(std::vector<CandidatePath>& paths, const VplTracer& tracer, const Intersector& intersector,
                Counts& counts, const Keep& keep) {
    constexpr size_t kRun = SequenceSampler::kRun;
    std::mutex counting;
    parallel_for((paths.size() + kRun - 1) / kRun, 1, [&](size_t run) {
        const size_t first = run * kRun, many = std::min(kRun, paths.size() - first);
        const std::span<CandidatePath> mine(&paths[first], many);
        std::vector<Ray> rays(many);
        std::vector<Hit> hits(many);
        std::vector<ChosenStart> starts(many);
        std::vector<float> flux_w(many);
        for (size_t i = 0; i < many; ++i) rays[i] = mine[i].start.first.ray;
        intersector.closest_hits(rays, hits, Coherence::Incoherent);
        for (size_t i = 0; i < many; ++i) {
            starts[i] = mine[i].start;
            if (!hits[i].valid() || !keep(mine[i], hits[i])) starts[i].first.power_w = Rgb(0);
        }
        Counts of_run;
        of_run.photon_rays += many;
        tracer.see(starts, flux_w, of_run);
        for (size_t i = 0; i < many; ++i) mine[i].flux_w = flux_w[i];
        const std::scoped_lock lock(counting);
        counts += of_run;
    });
    std::erase_if(paths, [](const CandidatePath& path) { return !(path.flux_w > 0); });
}

void sort_by_place(std::vector<CandidatePath>& paths) {
    std::ranges::sort(paths, [](const CandidatePath& a, const CandidatePath& b) {
        return std::pair(a.place, a.left.slot) < std::pair(b.place, b.left.slot);
    });
}

/// The paths of the frame before, where they are now; in no order, and none that its lamp does not see any more.
std::vector<CandidatePath> paths_that_stay(const LeftVplPaths& before, const PastPose* pose, const TexelMapPass& map,
                                           const EmissionSampler& emission, const Scene& scene) {
    std::vector<CandidatePath> paths;
    if (before.lights != emission.lights()) return paths;
    paths.reserve(before.paths.size());
    for (const LeftVplPath& left : before.paths) {
        const gpu::TexelRun* run = map.run_of(left.light);
        if (!run || left.instance >= scene.instances.size() ||
            left.triangle >= scene.meshes[scene.instances[left.instance].mesh].triangles.size() ||
            (pose && !pose->triangle(scene, left.instance, left.triangle)))
            continue;
        const TriangleCorners corners = world_triangle(scene, left.instance, left.triangle);
        const vec3 point = corners.p[0] + left.barycentrics.x * (corners.p[1] - corners.p[0]) +
                           left.barycentrics.y * (corners.p[2] - corners.p[0]);
        CandidatePath path{.left = left, .start = {}};
        EmissionSample& first = path.start.first;
        if (!emission.aim(left.light, point, path.left.u_position, path.left.u_direction) ||
            !emission.sample_light(left.light, run->expected, path.left.u_position, path.left.u_direction, first))
            continue;
        const vec3 way = point - first.ray.origin;
        first.ray.direction = glm::normalize(way);
        path.place = glm::length(way);  // what it is to meet, until that is known
        paths.push_back(path);
    }
    return paths;
}

/// Takes out up to `most` where they are crowded, the most crowded first.
void thin_out(std::vector<CandidatePath>& paths, uint32_t slots, uint32_t most) {
    struct Crowded {
        double share;
        size_t path;
    };
    std::vector<Crowded> crowded;
    for (size_t i = 1; i + 1 < paths.size(); ++i) {
        const double share = paths[i + 1].place - paths[i - 1].place;
        if (share < kCrowded / slots) crowded.push_back({share, i});
    }
    std::ranges::sort(crowded, [](const Crowded& a, const Crowded& b) {
        return std::pair(a.share, a.path) < std::pair(b.share, b.path);
    });
    std::vector<bool> gone(paths.size());
    uint32_t taken = 0;
    for (const Crowded& one : crowded) {
        if (taken == most) break;
        if (gone[one.path - 1] || gone[one.path + 1]) continue;  // it has room now
        gone[one.path] = true;
        ++taken;
    }
    size_t kept = 0;
    for (size_t i = 0; i < paths.size(); ++i)
        if (!gone[i]) paths[kept++] = paths[i];
    paths.resize(kept);
}

/// Where `many` more are to go between places that are sorted: into the longest ways between them, spread evenly there.
std::vector<double> places_between(const std::vector<CandidatePath>& paths, uint32_t many, RandomStream random) {
    struct Way {
        double from, length;
        double ends;  // ways that it would be divided into by none more: 1, 1/2 at an end of the curve, 0 of all of it
        uint32_t more = 0;

        double divided() const { return length / (ends + more); }
    };
    std::vector<Way> ways;
    double from = 0;
    for (size_t i = 0; i <= paths.size(); ++i) {
        const double to = i < paths.size() ? paths[i].place : 1;
        ways.push_back({from, to - from, (i > 0 ? 0.5 : 0) + (i < paths.size() ? 0.5 : 0)});
        from = to;
    }
    const auto shorter = [&](size_t a, size_t b) {
        return std::pair(ways[a].divided(), b) < std::pair(ways[b].divided(), a);
    };
    std::priority_queue<size_t, std::vector<size_t>, decltype(shorter)> longest(shorter);
    for (size_t i = 0; i < ways.size(); ++i) longest.push(i);
    for (uint32_t i = 0; i < many; ++i) {
        const size_t way = longest.top();
        longest.pop();
        ++ways[way].more;
        longest.push(way);
    }
    std::vector<double> places;
    for (size_t i = 0; i < ways.size(); ++i) {
        const Way& way = ways[i];
        if (way.more == 0) continue;
        // Half a step from whatever is there to divide it by, and all of them moved by up to half a step.
        const double before = i > 0 ? 0.5 : 0, shift = double{random.next()};
        for (uint32_t k = 0; k < way.more; ++k) places.push_back(way.from + way.divided() * (before + k + shift));
    }
    return places;
}

}  // namespace

std::string LeftVplPaths::encode() const {
    const PathsHead head{kPathsMagic, kPathsVersion, slots, lights, static_cast<uint32_t>(paths.size()), 0, seed};
    std::string text(reinterpret_cast<const char*>(&head), sizeof head);
    return text.append(reinterpret_cast<const char*>(paths.data()), paths.size() * sizeof(LeftVplPath));
}

LeftVplPaths LeftVplPaths::decode(std::string_view text, uint32_t slots) {
    PathsHead head{};
    if (text.size() >= sizeof head) std::memcpy(&head, text.data(), sizeof head);
    if (head.magic != kPathsMagic || head.version != kPathsVersion || head.slots != slots || head.paths > slots ||
        text.size() != sizeof head + head.paths * sizeof(LeftVplPath))
        throw Error(ErrorCode::Conflict, "the frame before left no virtual point lights of so many paths");
    LeftVplPaths left{.slots = slots, .lights = head.lights, .seed = head.seed, .paths = {}};
    left.paths.resize(head.paths);
    copy_elements(text.data() + sizeof head, std::span(left.paths));
    std::vector<bool> taken(slots);
    for (const LeftVplPath& path : left.paths) {
        if (path.slot >= slots || taken[path.slot])
            throw Error(ErrorCode::Conflict, "the frame before left light paths that cannot be");
        taken[path.slot] = true;
    }
    return left;
}

VplsBetweenFrames::VplsBetweenFrames(const IncrementalVplParams& params, uint32_t slots)
    : params_(params), slots_(slots) {
    if (params_.on) left_ = LeftVplPaths{.slots = slots_, .lights = 0, .seed = 0, .paths = {}}.encode();
}

uint64_t VplsBetweenFrames::bytes_for(const IncrementalVplParams& params, uint32_t slots) {
    return params.on ? slots * (2 * sizeof(LeftVplPath) + sizeof(CandidatePath) + sizeof(ChosenStart) +
                                sizeof(uint32_t) + sizeof(double))
                     : 0;
}

void VplsBetweenFrames::follow(FrameBefore before) {
    if (!params_.on) {
        if (!before.left.empty()) throw Error(ErrorCode::Conflict, "the method's frames stand alone");
        return;
    }
    left_before_ = LeftVplPaths::decode(before.left, slots_);
    followed_.follow(before.left);
    before_ = std::move(before);
}

void VplsBetweenFrames::renew(const VplTracer& tracer, const EmissionSampler& emission, const RenderContext& context,
                              Stats& stats) {
    const Scene& scene = context.scene;
    const Intersector& intersector = *context.intersector;
    const uint64_t seed = context.seed;
    context.budget.record("vpls_between_frames", bytes_for(params_, slots_));
    seed_ = left_before_.paths.empty() ? seed : left_before_.seed;
    const TexelMapPass map(tracer.map(), seed_, 0);
    const auto flux = [&] {
        const StageTimer timer(stats, "rsm");
        return FluxCurve(tracer.see_flux(map, stats.counts));
    }();
    const StageTimer timer(stats, "vpl_generation");
    std::vector<CandidatePath> paths;
    if (flux.total_w() > 0) {
        paths = paths_that_stay(left_before_, before_.pose.get(), map, emission, scene);
        look_along(paths, tracer, intersector, stats.counts, [](const CandidatePath& path, const Hit& hit) {
            return std::fabs(double{hit.t} - path.place) <= double{kMeets} * path.place;
        });
        for (CandidatePath& path : paths)
            path.place = flux.share_before(
                map.curve_place(*map.run_of(path.left.light), path.left.u_position, path.left.u_direction));
        sort_by_place(paths);
        const bool follows = !paths.empty();
        const uint32_t most_new = follows ? std::min(params_.new_vpls, slots_) : slots_;
        const auto room = static_cast<uint32_t>(slots_ - paths.size());
        if (room < most_new) thin_out(paths, slots_, most_new - room);
        stats.counts.vpls_kept += paths.size();
        const auto more = std::min(most_new, static_cast<uint32_t>(slots_ - paths.size()));

        std::vector<bool> taken(slots_);
        for (const CandidatePath& path : paths) taken[path.left.slot] = true;
        uint32_t slot = 0;
        std::vector<CandidatePath> added;
        constexpr uint64_t kPlacesStream = 2;  // of RandomDomain::Photons in a pass; 1: the map's
        for (const double place :
             places_between(paths, more, RandomStream(seed, RandomDomain::Photons, 0, kPlacesStream))) {
            while (taken[slot]) ++slot;
            const TexelMapPass::TexelNumbers numbers = tracer.numbers_of(map, flux.texel_at(place));
            CandidatePath path{.left = {slot++, numbers.light, numbers.u_position, numbers.u_direction, 0, 0, {}},
                               .start = {},
                               .place = flux.share_before(map.curve_place(*map.run_of(numbers.light),
                                                                          numbers.u_position, numbers.u_direction))};
            if (emission.sample_light(numbers.light, numbers.expected, numbers.u_position, numbers.u_direction,
                                      path.start.first))
                added.push_back(path);
        }
        look_along(added, tracer, intersector, stats.counts, [](CandidatePath& path, const Hit& hit) {
            path.left.instance = hit.instance, path.left.triangle = hit.triangle;
            path.left.barycentrics = {hit.u, hit.v};
            return true;
        });
        stats.counts.vpls_new += added.size();
        paths.insert(paths.end(), added.begin(), added.end());
        sort_by_place(paths);
    }

    paths_ = {std::vector<ChosenStart>(slots_), std::vector<uint32_t>(slots_)};
    LeftVplPaths left{.slots = slots_, .lights = emission.lights(), .seed = seed_, .paths = {}};
    for (size_t i = 0; i < paths.size(); ++i) {
        const double begin = i > 0 ? 0.5 * (paths[i - 1].place + paths[i].place) : 0;
        const double end = i + 1 < paths.size() ? 0.5 * (paths[i].place + paths[i + 1].place) : 1;
        const double flux_w = (end - begin) * flux.total_w();
        ChosenStart& start = paths_.starts[paths[i].left.slot];
        start.first = paths[i].start.first;
        start.first.power_w *= static_cast<float>(flux_w / double{paths[i].flux_w});
        start.reflected_w = static_cast<float>(flux_w);
        paths_.order[paths[i].left.slot] = static_cast<uint32_t>(i);
        left.paths.push_back(paths[i].left);
    }
    left_ = left.encode();
}

}  // namespace photond
