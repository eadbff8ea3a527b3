#include "server/worker/job_runner.h"

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdio>

#include "protocol/param_json.h"
#include "protocol/worker_messages.h"
#include "renderer/film/film_file.h"
#include "server/job_vocabulary.h"
#include "server/worker/process_memory.h"
#include "server/worker/statistics.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr double kProgressSeconds = 0.25;

template <class... Arguments>
std::string formatted(const char* format, Arguments... arguments) {
    char text[512];
    std::snprintf(text, sizeof text, format, arguments...);
    return text;
}

PixelFilter filter_named(const std::string& name) {
    if (name == "gaussian") return PixelFilter::Gaussian;
    if (name == "blackman_harris") return PixelFilter::BlackmanHarris;
    return PixelFilter::Box;  // the reader of jobs knows no other
}

LayerSet layers_named(const std::vector<std::string>& names) {
    LayerSet layers;
    for (const LayerInfo& info : kLayers)
        if (std::find(names.begin(), names.end(), info.name) != names.end()) layers.add(info.layer);
    return layers;
}

double progress_of(const StopConditions& stop, uint32_t passes, double seconds) {
    double progress = 0;
    if (stop.passes) progress = std::max(progress, passes / static_cast<double>(*stop.passes));
    if (stop.seconds && *stop.seconds > 0) progress = std::max(progress, seconds / *stop.seconds);
    return std::min(progress, 1.0);
}

}  // namespace

std::unique_ptr<Method> make_method(const JobRequest& request) {
    const MethodInfo* info = find_method(request.method.name);
    if (!info) throw Error(ErrorCode::UnknownName, "/method/name", "there is no method \"" + request.method.name + "\"");
    const std::unique_ptr<MethodParams> params = info->make_params();
    std::vector<Fault> faults;
    read_params(*params, request.method.parameters, "/method/parameters", faults);
    if (!faults.empty()) {
        const std::string first = faults.front().detail;
        throw Error(ErrorCode::OutOfRange, first, std::move(faults));
    }
    params->check();
    return info->make(*params);
}

void JobControl::request_snapshot(std::filesystem::path path) {
    const std::lock_guard lock(mutex_);
    snapshot_ = std::move(path);
}

std::optional<std::filesystem::path> JobControl::take_snapshot() {
    const std::lock_guard lock(mutex_);
    return std::exchange(snapshot_, std::nullopt);
}

PassLoop::Result PassLoop::run(Stats& stats) {
    const Size2 size = context.view.film_size;
    const LayerSet layers = context.view.layers;
    context.budget.require("film", Film::bytes_for(size, layers));
    Result result{Film(size, layers), 0, false};
    context.budget.record("film", result.film.bytes());

    double start = wall_now_seconds();
    method.begin(context, stats);
    result.render_seconds += wall_now_seconds() - start;
    const auto stop_met = [&] {
        const uint32_t done = result.film.passes();
        return (stop.passes && done >= *stop.passes) ||
               (stop.seconds && done > 0 && result.render_seconds >= *stop.seconds);
    };
    while (!stop_met()) {
        start = wall_now_seconds();
        if (!cancel.cancelled()) method.run_pass(result.film.passes(), stats, cancel);
        if (cancel.cancelled()) {
            result.cancelled = true;  // the pass may be unfinished: nothing of it reaches the film
            break;
        }
        {
            const StageTimer timer(stats, "combine");
            method.resolve(result.film);
        }
        result.render_seconds += wall_now_seconds() - start;
        if (after_pass) after_pass(result.film, result.render_seconds);
    }
    return result;
}

View resolve_view(const JobRequest& request, const Scene& scene) {
    View view;
    const JobCamera& wanted = request.camera;
    std::optional<double> focus_distance = wanted.focus_distance;
    if (wanted.look_at) {
        const auto point = [&](const std::array<double, 3>& p) { return dvec3(p[0], p[1], p[2]); };
        const dvec3 eye = point(wanted.look_at->eye), target = point(wanted.look_at->target);
        view.camera = look_at_camera(eye - scene.origin, target - scene.origin, point(wanted.look_at->up),
                                     static_cast<float>(wanted.look_at->yfov));
        if (!focus_distance) focus_distance = glm::length(target - eye);
    } else {
        view.camera = find_camera(scene, wanted.name);
    }
    if (wanted.aperture > 0) {
        if (!focus_distance)
            throw Error(ErrorCode::MissingField, "/camera/focus_distance",
                        "a lens (aperture > 0) needs a focus_distance, unless look_at gives a target");
        view.camera.aperture_radius_m = static_cast<float>(wanted.aperture);
        view.camera.focus_distance_m = static_cast<float>(*focus_distance);
    }
    view.film_size = {request.width, request.height};
    view.filter = filter_named(request.filter);
    view.layers = layers_named(request.layers);
    return view;
}

/// What "finished" will say; filled as the job goes on, so that a failure keeps what was true before it.
struct JobRunner::Report {
    std::string state = "failed";
    uint32_t passes_done = 0;
    double seconds = 0;
    json film = nullptr;
    json statistics = nullptr;
    json artefacts = json::array();
    std::vector<std::filesystem::path> artefact_files;
    json failure = nullptr;
    json log = json::array();
};

JobRunner::JobRunner(SceneCache& scenes, Device device, unsigned max_threads, uint64_t memory_limit_bytes, Send send)
    : scenes_(scenes),
      device_(std::move(device)),
      max_threads_(max_threads),
      memory_limit_bytes_(memory_limit_bytes),
      send_(std::move(send)) {}

void JobRunner::save_artefacts(const Method& method, const std::filesystem::path& film_path, Report& report) {
    for (const MethodArtefact& artefact : method.artefacts()) {
        const std::filesystem::path path = artefact_path(film_path, artefact.name);
        artefact.write(path);
        report.artefact_files.push_back(path);
        report.artefacts.push_back(artefact.name);
        report.log.push_back(formatted("kept %s: %llu bytes", artefact.name.c_str(),
                                       static_cast<unsigned long long>(std::filesystem::file_size(path))));
    }
}

void JobRunner::run(const json& order, JobControl& control) noexcept {
    Report report;
    const auto fail = [&](json failure) {
        report.state = "failed";
        report.log.push_back("failed: " + failure["detail"].get<std::string>());
        report.failure = std::move(failure);
        report.film = nullptr;
        report.artefacts = json::array();
        for (const std::filesystem::path& file : report.artefact_files) {
            std::error_code gone_already;
            std::filesystem::remove(file, gone_already);
        }
    };
    // Code below this function throws and never catches.
    try {
        render(order, control, report);
    } catch (const Error& error) {
        fail(failure_json(error));
    } catch (const std::bad_alloc&) {
        fail(failure_json(ErrorCode::OutOfMemory, "ran out of memory under the worker's limit of " +
                                                      std::to_string(memory_limit_bytes_) +
                                                      " bytes; lower the image size or the method's parameters"));
    } catch (const std::exception& defect) {
        spdlog::error("job {}: {}", order.value("job", json(nullptr)).dump(), defect.what());
        fail(failure_json(ErrorCode::Internal, "internal error, written to the log under this job's id"));
    }
    send_({{"type", "finished"},
           {"job", order.value("job", json(nullptr))},
           {"attempt", order.value("attempt", json(nullptr))},
           {"state", report.state},
           {"passes_done", report.passes_done},
           {"seconds", report.seconds},
           {"film", report.film},
           {"statistics", report.statistics},
           {"artefacts", report.artefacts},
           {"failure", report.failure},
           {"log", report.log},
           {"stopping", control.stopping.load()}});
    release_free_memory();  // off everybody's clock, and before the next job's baseline is taken
}

void JobRunner::render(const json& order, JobControl& control, Report& report) {
    const json& job = order.at("job");
    const json attempt = order.value("attempt", json(nullptr));
    send_({{"type", "started"}, {"job", job}, {"attempt", attempt}});
    const JobRequest request = parse_job_request(order.at("request"), job_vocabulary());
    const std::unique_ptr<Method> method = make_method(request);
    const SceneSource source = SceneSource::from_json(order.at("scene"));
    const std::filesystem::path film_path = order.at("film").get<std::string>();
    const json limits = order.value("limits", json::object());
    const uint64_t memory_limit = std::min(memory_limit_bytes_, limits.value("memory_bytes", memory_limit_bytes_));
    const unsigned asked_threads = limits.value("threads", max_threads_);
    const unsigned threads = asked_threads == 0 ? max_threads_ : std::min(max_threads_, asked_threads);
    SceneVariant variant;
    if (request.environment) {
        variant.environment_id = request.environment->image;
        variant.environment_path = order.at("environment").at("path").get<std::string>();
        variant.environment_scale = request.environment->scale;
        variant.environment_rotation = request.environment->rotation;
    }
    variant.solid_glass = request.glass == "solid";
    variant.time_s = request.time;

    // Baseline: what is resident before this job's scene, as if the scene were not in the cache. Scenes of other jobs
    // that are kept idle count to the baseline.
    MemoryBudget budget(memory_limit);
    budget.require("film", Film::bytes_for({request.width, request.height}, layers_named(request.layers)));
    reset_peak_resident();
    const uint64_t warm_bytes = scenes_.bytes_of(source, variant), resident = resident_bytes();
    const uint64_t baseline = resident - std::min(resident, warm_bytes);

    const auto render_in_arena = [&] {
        Stats stats;
        const std::shared_ptr<const ReadyScene> ready = scenes_.get(source, variant, budget, stats);
        const Scene& scene = ready->scene;
        report.log.push_back(formatted(
            "scene %s: %llu triangles, %s", request.scene.c_str(),
            static_cast<unsigned long long>(scene.triangle_count),
            warm_bytes ? "ready from an earlier job"
                       : formatted("loaded in %.3f s, ray structure in %.3f s", stats.stage("load").wall_seconds,
                                   stats.stage("acceleration_build").wall_seconds)
                             .c_str()));
        for (const std::string& warning : scene.warnings) report.log.push_back("warning: " + warning);

        const RenderContext context{scene, *ready->intersector, resolve_view(request, scene), request.seed, budget};
        double last_progress = 0;
        const auto send_progress = [&](const Film& film, double seconds) {
            send_({{"type", "progress"},
                   {"job", job},
                   {"attempt", attempt},
                   {"passes_done", film.passes()},
                   {"progress", progress_of(request.stop, film.passes(), seconds)},
                   {"seconds", seconds}});
            last_progress = wall_now_seconds();
        };
        const auto save_film = [&](const Film& film, const std::filesystem::path& path) {
            FilmFile::save(film, path);
            send_({{"type", "film_saved"},
                   {"job", job},
                   {"attempt", attempt},
                   {"path", path.string()},
                   {"passes_done", film.passes()}});
        };
        const auto after_pass = [&](const Film& film, double seconds) {
            report.passes_done = film.passes(), report.seconds = seconds;
            if (wall_now_seconds() - last_progress >= kProgressSeconds) send_progress(film, seconds);
            if (const auto snapshot = control.take_snapshot()) save_film(film, *snapshot);
        };
        PassLoop loop{*method, context, request.stop, control.cancel, after_pass};
        PassLoop::Result result = loop.run(stats);
        report.seconds = result.render_seconds;
        // The peak belongs to the render; writing the film is the runner's.
        const uint64_t peak = peak_resident_bytes();
        if (result.film.passes() > 0) {
            // A job that is to go on elsewhere leaves its film and nothing to look at.
            if (!(result.cancelled && control.stopping)) save_artefacts(*method, film_path, report);
            FilmFile::save(result.film, film_path);
            report.film = film_path.string();
            if (control.stopping)
                send_({{"type", "film_saved"},
                       {"job", job},
                       {"attempt", attempt},
                       {"path", film_path.string()},
                       {"passes_done", result.film.passes()}});
        }
        report.statistics = statistics_json({stats, result.film, budget, scene.needs, device_, request, source.id,
                                             result.render_seconds, threads, baseline, peak});
        report.state = result.cancelled ? "cancelled" : "succeeded";
        report.log.push_back(formatted("%s after %u passes, %.3f s of rendering on %u threads", report.state.c_str(),
                                       result.film.passes(), result.render_seconds, threads));
    };
    const tbb::global_control bound(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena arena(static_cast<int>(threads));
    arena.execute(render_in_arena);
}

}  // namespace photond
