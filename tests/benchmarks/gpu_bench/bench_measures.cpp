#include "tests/benchmarks/gpu_bench/bench_measures.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <numeric>
#include <sstream>

#include "renderer/error/curve.h"
#include "renderer/scene/scene.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"

namespace photond::bench {

namespace {

using nlohmann::json;

// Of a setting whose quality is asked.
constexpr uint32_t kTimedPasses = 16, kMostPasses = 4096;

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// What passes took, each by itself.
class PassTimes {
public:
    explicit PassTimes(bool on_gpu) : on_gpu_(on_gpu) {}

    /// `stats`: of one pass or build, whose stages may differ from the last one's.
    void add(const Stats& stats) {
        double whole = 0, shown = 0;
        for (const Stage& stage : stats.stages) {
            const double ms = 1e3 * (on_gpu_ ? stage.gpu_seconds : stage.wall_seconds);
            std::vector<double>& of_stage = stage_ms_[stage.name];
            of_stage.resize(whole_ms_.size());
            of_stage.push_back(ms);
            wall_ms_[stage.name] += 1e3 * stage.wall_seconds;
            whole += ms;
            if (stage.name != "readback") shown += ms;
        }
        whole_ms_.push_back(whole);
        shown_ms_.push_back(shown);
        for (auto& [name, ms] : stage_ms_) ms.resize(whole_ms_.size());
        counts += stats.counts;
    }

    bool has(const std::string& stage) const { return stage_ms_.contains(stage); }
    double median_ms(const std::string& stage) const { return median(stage_ms_.at(stage)); }
    /// Of all stages together.
    double median_ms() const { return median(whole_ms_); }
    double mean_ms() const { return mean(whole_ms_); }
    /// Of all but what brings the image to the host: whoever shows it on the same card has no need of that.
    double median_shown_ms() const { return median(shown_ms_); }
    double passes() const { return static_cast<double>(whole_ms_.size()); }

    /// Stages that took no time of the device's have the wall's alone.
    json stages() const {
        json stages = json::object();
        for (const auto& [name, ms] : stage_ms_) {
            stages[name] = {{"wall_ms", wall_ms_.at(name) / passes()}};
            if (on_gpu_ && mean(ms) > 0) stages[name].update({{"gpu_ms", mean(ms)}, {"gpu_ms_median", median(ms)}});
        }
        return stages;
    }

    Counts counts;

private:
    const bool on_gpu_;
    std::map<std::string, std::vector<double>> stage_ms_;
    std::map<std::string, double> wall_ms_;
    std::vector<double> whole_ms_, shown_ms_;
};

/// Ours beside what was published, and how many times as fast: `ms_of` a stage, 0 where there is none.
template <class StageMs>
json beside_published(const json& published_ms, const StageMs& ms_of) {
    json table = json::object();
    for (const auto& [name, published] : published_ms.items()) {
        double ms = 0;
        std::istringstream parts(name);
        for (std::string part; std::getline(parts, part, '+');) ms += ms_of(part);
        const double theirs_ms = published.template get<double>();
        table[name] = {
            {"published_ms", theirs_ms}, {"ms", ms}, {"times_as_fast", ms > 0 ? json(theirs_ms / ms) : json(nullptr)}};
    }
    return table;
}

/// The end of a line on stderr: what ours has no time of is left out.
void print_published(const json& result) {
    if (result.contains("published"))
        for (const auto& [name, row] : result["published"].items())
            if (!row["times_as_fast"].is_null())
                std::cerr << "; " << name << " " << row["ms"].get<double>() << " ms of " << row["published_ms"]
                          << ", x " << row["times_as_fast"].get<double>();
    std::cerr << std::endl;
}

json counts_json(const Counts& counts, double passes) {
    json object = json::object();
    const auto add = [&](const char* name, uint64_t count) {
        if (count > 0) object[name] = static_cast<double>(count) / passes;
    };
    add("camera_rays", counts.camera_rays), add("bounce_rays", counts.bounce_rays);
    add("shadow_rays", counts.shadow_rays), add("photon_rays", counts.photon_rays);
    add("photons_emitted", counts.photons_emitted), add("photons_stored", counts.photons_stored);
    add("splats", counts.splats), add("splat_contributions", counts.splat_contributions);
    add("vpls", counts.vpls);
    return object;
}

/// Compiles.
void run_first(Run& run, uint32_t passes) {
    for (uint32_t i = 0; i < passes; ++i) run.pass(false);
    run.settle();
}

/// Brings the clocks up: a card that had nothing to do runs at a fifth of its speed at first.
void warm_up(Run& run) {
    constexpr double kLeastSeconds = 0.5;
    for (const double end = run.seconds + kLeastSeconds; run.seconds < end;) run.pass(false);
    run.settle();
}

/// Each pass begins while the one before is folded into the film.
PassTimes run_passes(Run& run, uint32_t passes, bool on_gpu) {
    PassTimes times(on_gpu);
    for (uint32_t i = 0; i < passes; ++i) {
        run.stats = {};
        run.pass(i + 1 < passes);
        times.add(run.stats);
    }
    return times;
}

/// The device's, of all stages.
double gpu_seconds(const Stats& stats) {
    double seconds = 0;
    for (const Stage& stage : stats.stages) seconds += stage.gpu_seconds;
    return seconds;
}

json reference_json(const Reference& reference, const std::string& layer) {
    const std::optional<double>& own = reference.own_relative_mse.at(layer);
    return {{"seconds", reference.seconds}, {"own_relative_mse_at_most", own ? json(*own) : json(nullptr)}};
}

}  // namespace

json time_passes(const Entry& entry, Place& place, bool on_gpu) {
    Run run(entry.rendering, place, on_gpu);
    PassTimes begin(on_gpu);
    begin.add(run.stats);
    run_first(run, entry.warm_up_passes);
    const std::string pixel_hash = run.film.pixel_hash();  // of a number of passes that does not hang on the clock
    warm_up(run);
    const double before = run.seconds;
    const PassTimes times = run_passes(run, entry.passes, on_gpu);
    const double seconds = (run.seconds - before) / times.passes();
    std::vector<double> alone_ms;
    for (uint32_t i = 0; i < entry.passes; ++i) alone_ms.push_back(1e3 * run.pass_alone());

    // What a scene that moves would have every frame do: a pass, and what the device did before the first one.
    const double frame_ms = on_gpu ? times.median_shown_ms() + begin.mean_ms() : times.median_ms();
    const double rays = static_cast<double>(times.counts.rays()) / times.passes();
    json result{{"begin_seconds", run.begin_seconds},
                {"begin_stages", begin.stages()},
                {"stages", times.stages()},
                {"ms_a_pass", times.mean_ms()},
                {"ms_a_pass_median", times.median_ms()},
                {"frame_ms", frame_ms},
                {"wall_ms_a_pass", 1e3 * seconds},
                {"wall_ms_of_a_pass_alone", median(alone_ms)},
                {"rays_per_second", rays / seconds},
                {"counts_a_pass", counts_json(times.counts, times.passes())},
                {"pixel_hash", pixel_hash}};
    if (!entry.published_ms.empty())
        result["published"] = beside_published(entry.published_ms, [&](const std::string& stage) {
            if (stage == "frame") return frame_ms;
            return times.has(stage) ? times.median_ms(stage) : begin.has(stage) ? begin.median_ms(stage) : 0.0;
        });
    if (on_gpu) {
        result["rays_per_gpu_second"] = times.mean_ms() > 0 ? json(rays / (1e-3 * times.mean_ms())) : json(nullptr);
        result["device_bytes"] = place.device()->memory().structures();
    }
    std::cerr << "  " << times.median_ms() << " ms a pass, " << frame_ms << " ms a frame, wall " << 1e3 * seconds
              << " ms, alone " << median(alone_ms) << " ms";
    print_published(result);
    return result;
}

json time_to_error(const Entry& entry, Place& place, bool on_gpu) {
    const TimeToError& wanted = *entry.time_to_error;
    const Reference& reference = place.reference(entry.rendering, wanted.reference);
    const ErrorMeter& meter = reference.meter(wanted.metric.layer);
    {
        Run compiles(entry.rendering, place, on_gpu);
        run_first(compiles, 1);
        warm_up(compiles);
    }
    Run run(entry.rendering, place, on_gpu);
    const double gpu_seconds_of_begin = gpu_seconds(run.stats);
    const double least = *std::min_element(wanted.targets.begin(), wanted.targets.end());
    CurveSchedule schedule;
    std::vector<TimedError> on_clock, of_passes, of_gpu;
    json points = json::array();
    // A time is known once another point bears it out.
    while (on_clock.empty() ||
           (run.seconds - run.begin_seconds < wanted.most_seconds && !photond::time_to_error(on_clock, least))) {
        run.pass(!schedule.is_due(run.film.passes() + 1, run.seconds));
        if (!schedule.is_due(run.film.passes(), run.seconds)) continue;
        run.settle();
        schedule.skip_to(run.film.passes(), run.seconds);
        const std::vector<double> error = meter.measure(wanted.metric.metric, run.image(wanted.metric.layer));
        if (error.empty()) throw Error(ErrorCode::Unsupported, "the reference is black: " + wanted.metric.name());
        on_clock.push_back({run.seconds, error[0]});
        of_passes.push_back({run.seconds - run.begin_seconds, error[0]});
        if (on_gpu) of_gpu.push_back({gpu_seconds(run.stats) - gpu_seconds_of_begin, error[0]});
        points.push_back({{"seconds", run.seconds}, {"passes", run.film.passes()}, {"error", error[0]}});
    }
    const auto seconds_to = [](const std::vector<TimedError>& curve, double target) {
        const std::optional<double> seconds = photond::time_to_error(curve, target);
        return seconds ? json(*seconds) : json(nullptr);
    };
    json reached = json::array();
    std::cerr << " ";
    for (const double target : wanted.targets) {
        reached.push_back({{"target", target},
                           {"seconds", seconds_to(on_clock, target)},
                           {"seconds_of_passes", seconds_to(of_passes, target)},
                           {"gpu_seconds_of_passes", seconds_to(of_gpu, target)}});
        std::cerr << " " << reached.back();
    }
    std::cerr << " in the end " << points.back() << std::endl;
    return {{"metric", wanted.metric.name()},
            {"reference", reference_json(reference, wanted.metric.layer)},
            {"begin_seconds", run.begin_seconds},
            {"reached", reached},
            {"curve", points}};
}

namespace {

/// One row of rank_by_quality().
json quality_of(const Rendering& setting, const Entry& entry, Place& place, const Reference& reference, bool on_gpu) {
    const Quality& wanted = *entry.quality;
    Run run(setting, place, on_gpu);
    const double begin_ms = 1e3 * gpu_seconds(run.stats);
    run_first(run, entry.warm_up_passes);
    warm_up(run);
    const double ms = run_passes(run, kTimedPasses, on_gpu).median_ms();
    const auto passes = static_cast<uint32_t>(std::clamp(wanted.milliseconds / ms, 1.0, double{kMostPasses}));
    std::map<std::string, std::vector<double>> errors;
    for (uint32_t repeat = 0; repeat < wanted.repeats; ++repeat) {
        run.begin_film();
        for (uint32_t i = 0; i < passes; ++i) run.pass(i + 1 < passes);
        for (const LayerMetric& metric : wanted.metrics) {
            const auto error = reference.meter(metric.layer).measure(metric.metric, run.image(metric.layer));
            if (error.empty()) throw Error(ErrorCode::Unsupported, "the reference is black: " + metric.name());
            errors[metric.name()].push_back(error[0]);
        }
    }
    json row{{"name", setting.name}, {"method", setting.method}, {"parameters", setting.parameters},
             {"ms_a_pass", ms},      {"begin_ms", begin_ms},     {"passes", passes},
             {"ms", ms * passes}};
    for (const auto& [name, values] : errors) row["errors"][name] = {{"mean", mean(values)}, {"each", values}};
    return row;
}

}  // namespace

json rank_by_quality(const Entry& entry, Place& place, bool on_gpu) {
    const Quality& wanted = *entry.quality;
    const Reference& reference = place.reference(entry.rendering, wanted.reference);
    json rows = json::array();
    for (const Rendering& setting : wanted.settings) {
        std::cerr << "  (" << rows.size() + 1 << " of " << wanted.settings.size() << ": " << setting.name << ")"
                  << std::endl;
        try {
            rows.push_back(quality_of(setting, entry, place, reference, on_gpu));
        } catch (const gpu::DeviceLost&) {
            throw;
        } catch (const Error& error) {
            rows.push_back({{"name", setting.name}, {"error", error.what()}});
        }
    }
    const std::string first = wanted.metrics.front().name();
    const auto error_of = [&](const json& row) {
        return row.contains("errors") ? row["errors"][first]["mean"].get<double>()
                                      : std::numeric_limits<double>::infinity();
    };
    std::stable_sort(rows.begin(), rows.end(), [&](const json& a, const json& b) { return error_of(a) < error_of(b); });
    for (const json& row : rows) {
        std::cerr << "  " << row["name"].get<std::string>() << ": ";
        if (row.contains("error"))
            std::cerr << row["error"].get<std::string>();
        else
            std::cerr << row["passes"] << " x " << row["ms_a_pass"].get<double>() << " ms";
        for (const LayerMetric& metric : wanted.metrics)
            if (row.contains("errors"))
                std::cerr << ", " << metric.name() << " " << row["errors"][metric.name()]["mean"].get<double>();
        std::cerr << std::endl;
    }
    return {{"milliseconds", wanted.milliseconds},
            {"reference", reference_json(reference, wanted.metrics.front().layer)},
            {"settings", rows}};
}

json time_voxels(const Entry& entry, Place& place) {
    constexpr uint32_t kWarmUpBuilds = 4;
    const Voxels& wanted = *entry.voxels;
    gpu::Device& device = *place.device();
    SparseVoxelOctreeGpu tree(place.device_scene(), make_voxel_grid(place.scene().bounds, wanted.resolution),
                              wanted.surfaces);
    Stats first;
    tree.build_now(first);
    PassTimes times(true);
    std::vector<double> wall_ms;
    for (uint32_t i = 0; i < kWarmUpBuilds + wanted.builds; ++i) {
        const double start = wall_now_seconds();
        gpu::CommandList commands(device);
        tree.record_build(commands);
        commands.submit();
        commands.wait();
        const double elapsed = wall_now_seconds() - start;
        if (tree.grow_if_short()) throw Error(ErrorCode::Internal, "the same tree outgrew its room");
        if (i < kWarmUpBuilds) continue;
        Stats stats;
        commands.add_times(stats);
        times.add(stats);
        wall_ms.push_back(1e3 * elapsed);
    }
    json result{{"resolution", wanted.resolution},
                {"surfaces", wanted.surfaces},
                {"stages", times.stages()},
                {"ms", times.median_ms()},
                {"wall_ms", median(wall_ms)},
                {"voxels", tree.voxel_count()},
                {"bricks", tree.brick_count()},
                {"nodes", tree.node_count()},
                {"fragments", tree.fragment_count()},
                {"bytes", tree.device_bytes()},
                {"bytes_with_scratch", tree.device_bytes_with_scratch()},
                {"bytes_a_voxel", tree.bytes_a_voxel()}};
    if (!entry.published_ms.empty())
        result["published"] = beside_published(entry.published_ms, [&](const std::string& stage) {
            return times.has(stage) ? times.median_ms(stage) : 0.0;
        });
    std::cerr << "  " << times.median_ms() << " ms, " << tree.voxel_count() << " voxels of " << tree.bytes_a_voxel()
              << " bytes";
    print_published(result);
    return result;
}

}  // namespace photond::bench
