#include "server/worker/render_job.h"

#include <algorithm>
#include <cstdio>
#include <future>
#include <thread>

#include "protocol/error.h"
#include "renderer/backends/gpu/device.h"
#include "renderer/voxels/kept_voxels.h"
#include "server/method_params.h"
#include "server/worker/job_setup.h"
#include "server/worker/moving_passes.h"
#include "server/worker/off_the_clock.h"
#include "server/worker/process_memory.h"
#include "server/worker/statistics.h"

namespace photond {

using nlohmann::json;

namespace {

/// The most that FLIP's features of the reference may take (flip.h).
uint64_t most_flip_bytes(const MeasuringPlan& plan, Size2 size) {
    constexpr uint64_t kMostExposures = 16, kBytesAPixel = 20, kCopyBytesAPixel = 12;
    uint64_t bytes = 0;
    for (const LayerMetric& metric : plan.costly) {
        if (metric.metric != Metric::FlipLdr && metric.metric != Metric::FlipHdr) continue;
        const uint64_t exposures = metric.metric == Metric::FlipLdr ? 1 : kMostExposures;
        bytes += std::min(kFlipCacheBytes, kBytesAPixel * exposures * size.pixels()) + kCopyBytesAPixel * size.pixels();
    }
    return bytes;
}

/// Throws ErrorCode::Conflict unless passes can be added to the film as if it were this job's own.
void require_own_film(const SavedFilm& saved, const FilmIdentity& identity, Size2 size, LayerSet layers,
                      uint32_t first_pass) {
    require_alike(saved.identity, identity);
    if (saved.film.size() != size || !(saved.film.layers() == layers))
        throw Error(ErrorCode::Conflict, "it has another size or other layers");
    const std::vector<PassRanges::Range>& ranges = saved.film.pass_ranges().ranges();
    if (ranges.size() != 1 || ranges.front().first != first_pass || saved.film.next_pass() != ranges.front().end)
        throw Error(ErrorCode::Conflict, "it has passes " + saved.film.pass_ranges().text() +
                                             ", which are not those from " + std::to_string(first_pass) + " on");
}

}  // namespace

template <class... Arguments>
void RenderJob::log(const char* format, Arguments... arguments) {
    char text[512];
    std::snprintf(text, sizeof text, format, arguments...);
    report_.log.push_back(text);
}

RenderJob::RenderJob(const RenderOrder& order, JobControl& control, SceneCache& scenes, const Device& device,
                     JobReport& report, const Send& send)
    : order_(order),
      control_(control),
      scenes_(scenes),
      device_(device),
      report_(report),
      send_(send),
      method_(make_passes()),
      budget_(order.memory_bytes) {}

std::unique_ptr<Method> RenderJob::make_passes() {
    const JobRequest& request = order_.request;
    const auto make = [&request, kind = device_.kind] { return make_method(request, kind); };
    if (request.shutter == 0) return make();
    (void)make();  // throws now what it would in the first pass
    const auto show = [this](double time_s, Stats& stats) {
        scenes_.show({order_.moment.animation, time_s}, budget_, stats);
        return context();
    };
    return std::make_unique<MovingPasses>(MovingPasses::Job{make, show, request.time, request.shutter, order_.seed()});
}

RenderContext RenderJob::context() {
    return {ready_->scene,
            ready_->intersector.get(),
            resolve_view(order_.request, ready_->scene),
            order_.seed(),
            budget_,
            ready_->device_scene.get(),
            ready_->host_intersector.get(),
            ready_->kept_voxels.get()};
}

void RenderJob::run() {
    const JobRequest& request = order_.request;
    budget_.require("film", Film::bytes_for({request.width, request.height}, layers_named(request.layers)));
    load_scene();
    prepare_measuring();
    finish(render());
}

void RenderJob::load_scene() {
    // Baseline: what is resident before this job's scene, as if the scene were not in the cache. Scenes of other jobs
    // that are kept idle count to the baseline.
    const uint64_t resident = resident_bytes();
    const JobMethod& method = order_.request.method;
    const bool on_host = traces_on_host(*find_method(method.name), method.parameters);
    const bool warm = scenes_.holds(order_.source, order_.variant);
    if (order_.before) follow_frame_before();
    ready_ = scenes_.get(order_.source, order_.variant, budget_, stats_, on_host, order_.moment);
    const uint64_t warm_bytes = warm ? ready_->bytes() + ready_->kept_bytes() +
                                           (device_.software ? ready_->device_bytes() + ready_->kept_device_bytes() : 0)
                                     : 0;
    baseline_bytes_ = resident - std::min(resident, warm_bytes);
    if (device_.in_use) note_idle_device_memory();
    const auto triangles = static_cast<unsigned long long>(ready_->scene.triangle_count);
    if (warm)
        log("scene %s: %llu triangles, ready from an earlier job; posed in %.3f s", order_.request.scene.c_str(),
            triangles, stats_.stage("pose").wall_seconds);
    else
        log("scene %s: %llu triangles, loaded in %.3f s, ray structure in %.3f s", order_.request.scene.c_str(),
            triangles, stats_.stage("load").wall_seconds, stats_.stage("acceleration_build").wall_seconds);
    for (const std::string& warning : ready_->scene.warnings) report_.log.push_back("warning: " + warning);
}

void RenderJob::follow_frame_before() {
    const RenderMessage::FrameBefore& named = *order_.before;
    try {
        FrameBefore before;
        before.left = FilmFile::load_left(
            named.film, film_identity(order_.request, order_.source.id, order_.streams, device_), order_.memory_bytes);
        if (before.left.empty()) throw Error(ErrorCode::Conflict, "it left nothing");
        const SceneMoment then{order_.moment.animation, named.time};
        before.pose = std::make_shared<const PastPose>(
            scenes_.get(order_.source, order_.variant, budget_, stats_, false, then)->scene);
        method_->follow(std::move(before));
        log("follows the frame at %.6g s", named.time);
    } catch (const Error& error) {  // not this frame's fault: it can be rendered all the same
        report_.log.push_back(std::string("warning: the frame before cannot be followed (") + error.what() +
                              "); this one begins as the first does");
    }
}

void RenderJob::note_idle_device_memory() {
    gpu::Memory& memory = device_.in_use->memory();
    memory.reset_peak();  // while the scene was uploaded no method held anything
    idle_device_structures_ = memory.structures();
    const std::map<std::string, uint64_t> kept = ready_->kept_voxels->device_structures();
    for (const auto* held : {&ready_->device_structures, &kept})
        for (const auto& [name, bytes] : *held) idle_device_structures_[name] -= bytes;
}

std::optional<DeviceMemoryUse> RenderJob::device_memory() const {
    if (!device_.in_use) return std::nullopt;
    const gpu::Memory& memory = device_.in_use->memory();
    DeviceMemoryUse use{memory.structures(), memory.peak_bytes()};
    for (const auto& [name, bytes] : idle_device_structures_) {
        use.structures[name] -= bytes;
        use.peak_bytes -= bytes;
    }
    std::erase_if(use.structures, [](const auto& structure) { return structure.second == 0; });
    return use;
}

void RenderJob::prepare_measuring() {
    const JobRequest& request = order_.request;
    const bool with_reference = order_.reference.has_value();
    MeasuringPlan plan = MeasuringPlan::of(request, with_reference);
    std::optional<LoadedReference> reference;
    if (with_reference) {
        const OffTheClock loading(stats_, kReferenceLoadStage, meters_);
        reference = load_reference(*order_.reference, plan.layers,
                                   order_.memory_bytes - std::min(order_.memory_bytes, budget_.accounted_bytes()));
        const auto passes = [](const ReferenceImage& image) {
            return image.passes ? std::to_string(*image.passes) + " passes" : "an image";
        };
        log("reference: %u x %u pixels, %s%s", reference->first.size.width, reference->first.size.height,
            passes(reference->first).c_str(),
            reference->second ? (" and another of " + passes(*reference->second)).c_str() : "");
    }
    errors_.emplace(Size2{request.width, request.height}, std::move(reference), plan.layers);
    budget_.require("error_measuring", errors_->bytes() + most_flip_bytes(plan, {request.width, request.height}));
    budget_.record("error_measuring", errors_->bytes());
    follower_.emplace(std::move(plan), *errors_, stats_, meters_);
    saver_.emplace(film_identity(request, order_.source.id, order_.streams, device_), order_.save_seconds, stats_,
                   meters_);
}

std::optional<Film> RenderJob::film_to_go_on_with() {
    if (!order_.resume) return std::nullopt;
    const JobRequest& request = order_.request;
    try {
        SavedFilm saved = FilmFile::load(*order_.resume, order_.memory_bytes);
        require_own_film(saved, saver_->identity(), {request.width, request.height}, layers_named(request.layers),
                         request.first_pass);
        FilmHistory before = FilmHistory::parse(saved.history);
        method_->go_on_from(saved.state);
        left_before_ = std::move(saved.left);
        stats_.counts += before.counts;
        counts_before_ = before.counts;
        cores_before_ = before.cores;
        add_stages(stats_.stages, before.stages);
        skipped_before_ = std::move(before.skipped);
        seconds_before_ = before.seconds;
        resumed_passes_ = saved.film.passes();
        met_before_ = follower_->go_on_from(saved.film, std::move(before.curve), seconds_before_);
        log("goes on from a film of %u passes and %.3f s", resumed_passes_, seconds_before_);
        return std::move(saved.film);
    } catch (const Error& error) {  // not this job's fault: it can be rendered all the same
        report_.log.push_back(std::string("warning: the film of an earlier attempt cannot be gone on with (") +
                              error.what() + "); the job begins anew");
        return std::nullopt;
    }
}

PassLoop::Result RenderJob::render() {
    const JobRequest& request = order_.request;
    const RenderContext at_first = context();
    PassLoop loop{*method_, at_first, request.stop, control_.cancel,
                  [this](const Film& film, double seconds) { return after_pass(film, seconds); }};
    loop.pauses = [this](const Film& film, double seconds) {
        return follower_->may_measure(film, seconds) || saver_->due(film);
    };
    so_far_.emplace(
        control_.film_so_far, saver_->identity(), order_.origin,
        FilmSoFar::Told{[this](ProgressMessage progress) { send_(message_json(std::move(progress))); },
                        [this](const std::filesystem::path& path, uint32_t passes) { tell_saved(path, passes); }},
        stats_, meters_);
    loop.reader = &*so_far_;
    loop.first_pass = request.first_pass;
    loop.film = film_to_go_on_with();
    if (loop.film) {
        loop.seconds_before = seconds_before_;
        if (met_before_) loop.stop.passes = resumed_passes_;  // nothing is left to be done
        report_.passes_done = resumed_passes_, report_.seconds = seconds_before_;
        send_curve(0);
        tell_progress(*loop.film, seconds_before_);
    }
    meters_.cores.begin();
    PassLoop::Result result = loop.run(stats_);
    so_far_.reset();
    meters_.cores.end();
    add_skipped(stats_.skipped, skipped_before_);  // what a begin() of now did not name
    return result;
}

bool RenderJob::after_pass(const Film& film, double seconds) {
    report_.passes_done = film.passes(), report_.seconds = seconds;
    const size_t known_points = follower_->curve().size();
    const bool target_met = follower_->after_pass(film, seconds);
    if (follower_->curve().size() > known_points) send_curve(known_points);
    tell_progress(film, seconds);
    if (!target_met && saver_->due(film)) save(film, seconds, true);
    return target_met;
}

void RenderJob::finish(const PassLoop::Result& result) {
    const Film& film = result.film;
    const bool goes_on_elsewhere = result.cancelled && control_.stopping;
    report_.passes_done = film.passes(), report_.seconds = result.render_seconds;
    const uint64_t peak_bytes = meters_.peak.bytes();  // of the render; the rest is the runner's
    const std::optional<DeviceMemoryUse> on_device = device_memory();
    ErrorStatistics errors;
    std::vector<std::string> warnings;
    if (film.passes() > 0 && !goes_on_elsewhere) {
        const size_t known_points = follower_->curve().size();
        ResolvedFilm resolved(film);
        follower_->finish(resolved, result.render_seconds);
        if (follower_->curve().size() > known_points) send_curve(known_points);
        const OffTheClock measuring(stats_, kErrorMeasuringStage, meters_);
        const JobRequest& request = order_.request;
        errors = error_statistics(resolved, *errors_, follower_->plan(), follower_->curve().back(),
                                  request.reference ? to_json(*request.reference) : json(nullptr), order_.reference);
        if (std::ranges::all_of(resolved.pixels("beauty"), [](float value) { return value == 0; }))
            warnings.push_back(
                "every pixel is black: no light reaches what the camera sees; it may stand outside of a closed room, "
                "face away from the scene, or the scene may have no light");
    }
    std::string pixel_hash;
    for (const auto* some : {&errors.warnings, &warnings})
        for (const std::string& warning : *some) report_.log.push_back("warning: " + warning);
    report_.curve = to_json(follower_->curve());
    report_.error_now = follower_->error_now();
    if (film.passes() > 0) {
        // A job that is to go on elsewhere leaves its film and nothing to look at.
        if (!goes_on_elsewhere && result.passes_rendered > 0) save_artefacts();
        // Hashed while the disk takes the film.
        std::future<std::string> hash = std::async(std::launch::async, [&film] { return film.pixel_hash(); });
        save(film, result.render_seconds, control_.stopping);
        report_.film = order_.film;
        pixel_hash = hash.get();
    }
    const ClockUse clock{order_.request.stop.seconds, result.render_seconds,  result.begin_seconds,
                         result.passes_seconds,       result.passes_rendered, result.cut_off_seconds};
    report_.statistics =
        statistics_json({stats_, film, pixel_hash, budget_, ready_->scene.needs, device_, order_.request,
                         order_.source.id, result.render_seconds, order_.threads, baseline_bytes_, peak_bytes,
                         saver_->identity().settings, resumed_passes_, &errors, on_device, clock, warnings});
    report_.cores = core_use();
    report_.cores->derive(result.render_seconds, std::thread::hardware_concurrency());
    const Counts &all = stats_.counts, &before = counts_before_;
    report_.rendered = {.passes = film.passes() - resumed_passes_,
                        .seconds = result.render_seconds - seconds_before_,
                        .rays = {.camera = all.camera_rays - before.camera_rays,
                                 .bounce = all.bounce_rays - before.bounce_rays,
                                 .shadow = all.shadow_rays - before.shadow_rays,
                                 .photon = all.photon_rays - before.photon_rays},
                        .photons = all.photons_emitted - before.photons_emitted};
    report_.state = result.cancelled ? "cancelled" : "succeeded";
    if (result.cut_off_seconds > 0)
        log("the pass at hand was not done in time: %.3f s of it are thrown away", result.cut_off_seconds);
    if (!clock.kept())
        log("warning: %.3f s were asked for and %.3f s taken: the first pass is finished, and a pass takes %.3f s",
            *clock.asked_seconds, clock.render_seconds,
            clock.passes_seconds / std::max(clock.passes_rendered, uint32_t{1}));
    log("%s after %u passes, %.3f s of rendering on %u threads", report_.state.c_str(), film.passes(),
        result.render_seconds, order_.threads);
}

CoreUse RenderJob::core_use() {
    CoreUse use = meters_.cores.sums();
    return use += cores_before_;
}

FilmHistory RenderJob::history(double seconds) {
    FilmHistory history{seconds, stats_.counts, stats_.stages, stats_.skipped, follower_->curve(), {}, core_use()};
    history.standard_error_scale = errors_->last_standard_error_scale();
    return history;
}

void RenderJob::save(const Film& film, double seconds, bool tell) {
    const bool begun = film.passes() > resumed_passes_;
    saver_->save(film, history(seconds).text(), order_.film, order_.origin, method_->state(),
                 begun ? method_->left_to_next() : left_before_);
    if (tell) tell_saved(order_.film, film.passes());
}

void RenderJob::tell_saved(const std::filesystem::path& path, uint32_t passes) {
    send_(message_json(FilmSavedMessage{order_.job, order_.attempt, path, passes}));
}

void RenderJob::save_artefacts() {
    for (const MethodArtefact& artefact : method_->artefacts()) {
        const std::filesystem::path path = artefact_path(order_.film, artefact.name);
        artefact.write(path);
        report_.artefact_files.push_back(path);
        report_.artefacts.push_back(artefact.name);
        log("kept %s: %llu bytes", artefact.name.c_str(),
            static_cast<unsigned long long>(std::filesystem::file_size(path)));
    }
}

void RenderJob::send_curve(size_t first) {
    const std::vector<CurvePoint>& curve = follower_->curve();
    report_.curve = to_json(curve);
    report_.error_now = follower_->error_now();
    if (first == curve.size()) return;
    CurveMessage told{.job = order_.job, .attempt = order_.attempt, .points = {}, .error_now = follower_->error_now()};
    for (size_t i = first; i < curve.size(); ++i) told.points.push_back(to_json(curve[i]));
    send_(message_json(std::move(told)));
}

void RenderJob::tell_progress(const Film& film, double seconds) {
    const bool told = so_far_->tell({.job = order_.job,
                                     .attempt = order_.attempt,
                                     .passes_done = film.passes(),
                                     .progress = progress_of(order_.request.stop, film.passes(), seconds),
                                     .seconds = seconds,
                                     .error_now = follower_->error_now()});
    if (told) meters_.cores.look();
}

}  // namespace photond
