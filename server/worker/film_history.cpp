#include "server/worker/film_history.h"

#include <algorithm>

#include "protocol/error.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr std::pair<const char*, uint64_t Counts::*> kCounts[] = {{"camera_rays", &Counts::camera_rays},
                                                                  {"bounce_rays", &Counts::bounce_rays},
                                                                  {"shadow_rays", &Counts::shadow_rays},
                                                                  {"photon_rays", &Counts::photon_rays},
                                                                  {"photons_emitted", &Counts::photons_emitted},
                                                                  {"photons_stored", &Counts::photons_stored},
                                                                  {"splats", &Counts::splats},
                                                                  {"splat_contributions", &Counts::splat_contributions},
                                                                  {"vpls", &Counts::vpls},
                                                                  {"voxels", &Counts::voxels},
                                                                  {"nan_samples", &Counts::nan_samples},
                                                                  {"infinite_samples", &Counts::infinite_samples},
                                                                  {"photon_rays_saved", &Counts::photon_rays_saved},
                                                                  {"vpls_kept", &Counts::vpls_kept},
                                                                  {"vpls_new", &Counts::vpls_new},
                                                                  {"cache_hits", &Counts::cache_hits},
                                                                  {"cache_misses", &Counts::cache_misses},
                                                                  {"cache_refused", &Counts::cache_refused},
                                                                  {"vpls_offered", &Counts::vpls_offered},
                                                                  {"vpls_accepted", &Counts::vpls_accepted}};
static_assert((std::size(kCounts) + Counts::kBounces) * sizeof(uint64_t) == sizeof(Counts),
              "a count is missing from the table");
constexpr const char* kPhotonsByBounce = "photons_by_bounce";

template <class Value>
json nullable(const std::optional<Value>& value) {
    return value ? json(*value) : json(nullptr);
}

template <class Value>
std::optional<Value> optional_of(const json& value) {
    return value.is_null() ? std::nullopt : std::optional(value.get<Value>());
}

CurvePoint curve_point_of(const json& source) {
    CurvePoint point{source.at("seconds"), source.at("passes"), optional_of<uint64_t>(source.at("photons")), {}, {}};
    for (const auto& [name, value] : source.at("metrics").items()) point.metrics[name] = optional_of<double>(value);
    if (source.contains("intervals"))  // older films have none
        for (const auto& [name, ends] : source["intervals"].items()) point.intervals[name] = {ends.at(0), ends.at(1)};
    return point;
}

FilmHistory history_of(const json& source) {
    FilmHistory history;
    history.seconds = source.at("seconds");
    for (const auto& [name, count] : kCounts)
        history.counts.*count = source.at("counts").value(name, uint64_t{0});  // older films have fewer
    if (source.at("counts").contains(kPhotonsByBounce))
        source["counts"][kPhotonsByBounce].get_to(history.counts.photons_by_bounce);
    for (const json& stage : source.at("stages"))
        history.stages.push_back(
            {stage.at("name"), stage.at("wall_seconds"), stage.at("cpu_seconds"), stage.at("gpu_seconds")});
    for (const json& part : source.at("skipped"))
        history.skipped.push_back({part.at("what"), part.at("why"), part.at("bytes_saved")});
    if (source.contains("cores")) history.cores = read_part<CoreUse>(source["cores"], "history");
    for (const json& point : source.at("curve")) history.curve.push_back(curve_point_of(point));
    history.standard_error_scale = optional_of<double>(source.at("standard_error_scale"));
    return history;
}

}  // namespace

json to_json(const CurvePoint& point) {
    json metrics = json::object();
    for (const auto& [name, value] : point.metrics) metrics[name] = nullable(value);
    json intervals = json::object();
    for (const auto& [name, interval] : point.intervals) intervals[name] = {interval.least, interval.greatest};
    return {{"seconds", point.seconds},
            {"passes", point.passes},
            {"photons", nullable(point.photons)},
            {"metrics", std::move(metrics)},
            {"intervals", std::move(intervals)}};
}

json to_json(const std::vector<CurvePoint>& curve) {
    json points = json::array();
    for (const CurvePoint& point : curve) points.push_back(to_json(point));
    return points;
}

std::string FilmHistory::text() const {
    json all_counts = json::object(), all_stages = json::array(), all_skipped = json::array();
    for (const auto& [name, count] : kCounts) all_counts[name] = counts.*count;
    all_counts[kPhotonsByBounce] = counts.photons_by_bounce;
    for (const Stage& stage : stages)
        all_stages.push_back({{"name", stage.name},
                              {"wall_seconds", stage.wall_seconds},
                              {"cpu_seconds", stage.cpu_seconds},
                              {"gpu_seconds", stage.gpu_seconds}});
    for (const Skipped& part : skipped)
        all_skipped.push_back({{"what", part.what}, {"why", part.why}, {"bytes_saved", part.bytes_saved}});
    return json{{"seconds", seconds},       {"counts", all_counts},
                {"stages", all_stages},     {"skipped", all_skipped},
                {"curve", to_json(curve)},  {"standard_error_scale", nullable(standard_error_scale)},
                {"cores", part_json(cores)}}
        .dump(-1, ' ', false, json::error_handler_t::replace);
}

FilmHistory FilmHistory::parse(const std::string& text) {
    if (text.empty()) return {};
    try {
        return history_of(json::parse(text));
    } catch (const json::exception& fault) {
        throw Error(ErrorCode::Internal, std::string("the film's history cannot be read: ") + fault.what());
    }
}

FilmHistory& FilmHistory::operator+=(const FilmHistory& other) {
    seconds += other.seconds;
    counts += other.counts;
    add_stages(stages, other.stages);
    add_skipped(skipped, other.skipped);
    cores += other.cores;
    curve.clear();
    standard_error_scale.reset();
    return *this;
}

void add_stages(std::vector<Stage>& stages, const std::vector<Stage>& others) {
    for (const Stage& other : others) {
        auto same = std::find_if(stages.begin(), stages.end(), [&](const Stage& s) { return s.name == other.name; });
        if (same == stages.end()) same = stages.insert(stages.end(), {other.name, 0, 0, 0});
        same->wall_seconds += other.wall_seconds;
        same->cpu_seconds += other.cpu_seconds;
        same->gpu_seconds += other.gpu_seconds;
    }
}

void add_skipped(std::vector<Skipped>& skipped, const std::vector<Skipped>& others) {
    for (const Skipped& other : others)
        if (std::none_of(skipped.begin(), skipped.end(),
                         [&](const Skipped& part) { return part.what == other.what && part.why == other.why; }))
            skipped.push_back(other);
}

}  // namespace photond
