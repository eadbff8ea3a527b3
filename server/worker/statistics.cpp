#include "server/worker/statistics.h"

#include <unistd.h>

#include <cmath>

#include "protocol/param_json.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/left_out_json.h"
#include "server/method_params.h"

namespace photond {

using nlohmann::json;

namespace {

json clock_json(const ClockUse& clock) {
    const bool asked = clock.asked_seconds.has_value();
    const uint32_t passes = clock.passes_rendered;
    return {{"asked_seconds", asked ? json(*clock.asked_seconds) : json(nullptr)},
            {"overshoot_seconds", asked ? json(clock.overshoot_seconds()) : json(nullptr)},
            {"kept", asked ? json(clock.kept()) : json(nullptr)},
            {"begin_seconds", clock.begin_seconds},
            {"seconds_per_pass", passes ? json(clock.passes_seconds / passes) : json(nullptr)},
            {"passes_cut_off", clock.cut_off_seconds > 0 ? 1 : 0},
            {"cut_off_seconds", clock.cut_off_seconds}};
}

json per_second(double count, double seconds) { return seconds > 0 ? json(count / seconds) : json(nullptr); }

void flatten(const std::string& name, const json& value, std::vector<ImageAttribute>& attributes) {
    if (value.is_null()) return;
    const auto below = [&name](const std::string& key) {
        std::string path = name;
        return path.append(".").append(key);
    };
    if (value.is_object()) {
        for (const auto& [key, member] : value.items()) flatten(below(key), member, attributes);
    } else if (value.is_array()) {
        for (size_t i = 0; i < value.size(); ++i) {
            const json& item = value[i];
            if (item.is_object() && item.contains("name") && item["name"].is_string()) {
                json rest = item;
                rest.erase("name");
                flatten(below(item["name"].get<std::string>()), rest, attributes);
            } else {
                flatten(below(std::to_string(i)), item, attributes);
            }
        }
    } else if (value.is_string()) {
        attributes.push_back({name, value.get<std::string>()});
    } else if (value.is_boolean()) {
        attributes.push_back({name, value.get<bool>() ? 1.0 : 0.0});
    } else if (value.is_number_integer() && std::abs(value.get<double>()) > 0x1p53) {
        attributes.push_back({name, value.dump()});
    } else {
        attributes.push_back({name, value.get<double>()});
    }
}

json photons_by_bounce(const Counts& counts) {
    for (const uint64_t photons : counts.photons_by_bounce)
        if (photons > 0) return counts.photons_by_bounce;
    return nullptr;
}

}  // namespace

std::string job_hash(const JobRequest& request, const std::string& scene_id) {
    json canonical = naming_json(request);
    canonical.erase("priority"), canonical.erase("labels"), canonical.erase("quiet_machine");
    canonical["scene"] = scene_id.empty() ? request.scene : scene_id;
    const std::string text = canonical.dump(-1, ' ', false, json::error_handler_t::replace);
    return sha256_hex(text.data(), text.size());
}

json statistics_json(const StatisticsInput& input) {
    const Counts& counts = input.stats.counts;
    json stages = json::array();
    for (const Stage& stage : input.stats.stages)
        stages.push_back({{"name", stage.name},
                          {"wall_seconds", stage.wall_seconds},
                          {"cpu_seconds", stage.cpu_seconds},
                          {"gpu_seconds", stage.gpu_seconds > 0 ? json(stage.gpu_seconds) : json(nullptr)}});
    json needs = json::object();
    input.needs.visit([&](const char* name, bool needed) { needs[name] = needed; });
    const float alpha = input.needs.least_glossy_alpha;
    const JobMethod& method = input.request.method;
    const MethodInfo* known_method = find_method(method.name);
    const auto left_out = left_out_by(method.name, method.parameters, input.needs);
    json skipped = json::array();
    for (const Skipped& part : input.stats.skipped)
        skipped.push_back({{"what", part.what}, {"why", part.why}, {"bytes_saved", part.bytes_saved}});
    json pass_ranges = json::array();
    for (const PassRanges::Range& range : input.film.pass_ranges().ranges())
        pass_ranges.push_back({range.first, range.end});
    const ErrorStatistics nothing_measured;
    const ErrorStatistics& errors = input.errors ? *input.errors : nothing_measured;
    const auto passes = static_cast<double>(input.film.passes());
    const std::optional<DeviceMemoryUse>& on_device = input.device_memory;
    const double samples = passes * static_cast<double>(input.film.size().pixels());

    return {{"stages", stages},
            {"counts",
             {{"rays",
               {{"camera", counts.camera_rays},
                {"bounce", counts.bounce_rays},
                {"shadow", counts.shadow_rays},
                {"photon", counts.photon_rays}}},
              {"photons_emitted", counts.photons_emitted},
              {"photons_stored", counts.photons_stored},
              {"splats", counts.splats},
              {"splat_contributions", counts.splat_contributions},
              {"vpls", counts.vpls},
              {"voxels", counts.voxels},
              {"passes", input.film.passes()},
              {"photon_rays_saved", counts.photon_rays_saved},
              {"vpls_kept", counts.vpls_kept},
              {"vpls_new", counts.vpls_new},
              {"cache_hits", counts.cache_hits},
              {"cache_misses", counts.cache_misses},
              {"cache_refused", counts.cache_refused},
              {"vpls_offered", counts.vpls_offered},
              {"vpls_accepted", counts.vpls_accepted},
              {"photons_by_bounce", photons_by_bounce(counts)}}},
            {"rates",
             {{"rays_per_second", per_second(static_cast<double>(counts.rays()), input.render_seconds)},
              {"samples_per_second", per_second(samples, input.render_seconds)},
              {"passes_per_second", per_second(passes, input.render_seconds)},
              {"photons_per_second", counts.photons_emitted
                                         ? per_second(static_cast<double>(counts.photons_emitted), input.render_seconds)
                                         : json(nullptr)},
              {"photon_rays_per_second", counts.photon_rays
                                             ? per_second(static_cast<double>(counts.photon_rays), input.render_seconds)
                                             : json(nullptr)}}},
            {"memory",
             {{"structures", input.budget.structures()},
              {"accounted_bytes", input.budget.accounted_bytes()},
              {"baseline_resident_bytes", input.baseline_resident_bytes},
              {"peak_resident_bytes", input.peak_resident_bytes},
              {"device_structures", on_device ? json(on_device->structures) : json(nullptr)},
              {"peak_device_bytes", on_device ? json(on_device->peak_bytes) : json(nullptr)}}},
            {"needs", needs},
            {"least_glossy_alpha", std::isfinite(alpha) ? json(shortest_double(alpha)) : json()},
            {"left_out", left_out ? to_json(*left_out) : json()},
            {"skipped", skipped},
            {"warnings", input.warnings},
            {"device",
             {{"id", input.device.id},
              {"name", input.device.name},
              {"driver", input.device.driver.empty() ? json(nullptr) : json(input.device.driver)},
              {"software", input.device.software}}},
            {"version", PHOTOND_VERSION},
            {"host_cores", sysconf(_SC_NPROCESSORS_ONLN)},
            {"threads", input.threads},
            {"seed", input.request.seed},
            {"seconds", input.render_seconds},
            {"clock", input.clock ? clock_json(*input.clock) : json(nullptr)},
            {"passes", input.film.passes()},
            {"pass_ranges", pass_ranges},
            {"resumed_passes", input.resumed_passes},
            {"mergeable", known_method ? json(builds_on_before(*known_method, method.parameters).empty()) : json()},
            {"settings_hash", input.settings_hash.empty() ? json(nullptr) : json(input.settings_hash)},
            {"job_hash", job_hash(input.request, input.scene_id)},
            {"pixel_hash", input.pixel_hash.empty() ? json(nullptr) : json(input.pixel_hash)},
            {"nan_count", input.film.nan_count() + counts.nan_samples},
            {"infinity_count", input.film.infinity_count() + counts.infinite_samples},
            {"device_shared", false},  // the daemon knows
            {"host_shared", false},
            {"cores", nullptr},
            {"shared", nullptr},
            {"error", errors.error},
            {"error_interval", errors.error_interval},
            {"reference_error", errors.reference_error},
            {"reference", errors.reference},
            {"estimate", errors.estimate}};
}

std::vector<ImageAttribute> statistics_attributes(const json& statistics) {
    std::vector<ImageAttribute> attributes;
    if (!statistics.is_object()) return attributes;
    for (const auto& [key, value] : statistics.items()) flatten("photond:" + key, value, attributes);
    return attributes;
}

}  // namespace photond
