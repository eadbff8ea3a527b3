#include "server/service.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "server/service/artefact_files.h"
#include "server/service/attempts.h"
#include "server/service/backups.h"
#include "server/service/comparison_reports.h"
#include "server/service/comparisons.h"
#include "server/service/images.h"
#include "server/service/jobs.h"
#include "server/service/pictures.h"
#include "server/service/processes.h"
#include "server/service/purges.h"
#include "server/service/recovery.h"
#include "server/service/references.h"
#include "server/service/row_biases.h"
#include "server/service/scenes.h"
#include "server/service/sequence_errors.h"
#include "server/service/sequence_files.h"
#include "server/service/sequence_reports.h"
#include "server/service/service_core.h"
#include "server/service/store_upkeep.h"
#include "server/service/system_status.h"
#include "server/service/waiting_jobs.h"

namespace photond {

using nlohmann::json;

/// Each part knows those above it.
struct Service::Impl {
    explicit Impl(Options given);
    ~Impl() { processes.stop(); }

    ServiceCore core;
    ArtefactFiles artefact_files{core};
    Pictures pictures{core, artefact_files};
    Scenes scenes{core, artefact_files, pictures};
    Images images{core, artefact_files};
    References references{core};
    WaitingJobs waiting{core, references};
    Purges purges{core};
    Attempts attempts{core, pictures, scenes, references, waiting, purges};
    Jobs jobs{core, artefact_files, pictures, scenes, references, waiting, purges, attempts};
    Comparisons comparisons{core, scenes, references, purges, attempts, jobs};
    Sequences sequences{core, scenes, references, purges, attempts, jobs};
    SequenceFiles sequence_files{artefact_files, core, jobs, sequences};
    SequenceErrors sequence_errors{pictures, jobs.films, sequences};
    SequenceReports sequence_reports{artefact_files, sequences, sequence_errors, sequence_files};
    RowBiases biases{core, artefact_files, pictures, jobs.films,
                     [this](const std::string& id) { return comparisons.read_comparison(id); }};
    ComparisonReports reports{artefact_files, jobs, comparisons};
    Recovery recovery{core, attempts, purges};
    StoreUpkeep upkeep{core, recovery};
    Backups backups{core};
    SystemStatus system{core, pictures, attempts, upkeep};
    Processes processes{core, pictures, scenes, attempts};
};

Service::Impl::Impl(Options given) : core(std::move(given)) {
    recovery.begin();
    processes.start();
    upkeep.start();
    biases.start();
    const auto took = std::chrono::duration_cast<std::chrono::milliseconds>(SteadyClock::now() - core.begun);
    const std::lock_guard lock(core.mutex);  // workers take jobs already
    spdlog::info("store open after {} ms, {} jobs queued", took.count(), core.queue.size());
}

Service::Service(Options options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Service::~Service() = default;

std::filesystem::path Service::make_spool_path() { return impl_->core.files.fresh_spool_path(); }
void Service::check_disk(uint64_t bytes) const { impl_->core.check_disk(bytes); }
Added Service::add_scene(SceneUpload upload) { return impl_->scenes.add_scene(std::move(upload)); }
Page Service::list_scenes(const std::string& family, uint32_t limit, const std::string& cursor) {
    return impl_->scenes.list_scenes(family, limit, cursor);
}
json Service::get_scene(const std::string& id_or_name) { return impl_->scenes.get_scene(id_or_name); }
Artefact Service::thumbnail(const std::string& id_or_name) { return impl_->scenes.thumbnail(id_or_name); }
Artefact Service::baked_scene(const std::string& id_or_name) { return impl_->scenes.baked_scene(id_or_name); }
DrawnPreview Service::scene_preview(const std::string& id_or_name, const ScenePreview& wanted) {
    return impl_->scenes.scene_preview(id_or_name, wanted);
}
json Service::delete_scene(const std::string& id_or_name) { return impl_->scenes.delete_scene(id_or_name); }
Added Service::add_image(const std::filesystem::path& spooled, const std::string& media_type) {
    return impl_->images.add_image(spooled, media_type);
}
json Service::get_image(const std::string& id) { return impl_->images.get_image(id); }
Artefact Service::image_file(const std::string& id) { return impl_->images.image_file(id); }
Artefact Service::image_pixels(const std::string& id, const std::string& layer, const std::string& precision) {
    return impl_->images.image_pixels(id, layer, precision);
}
const JobVocabulary& Service::vocabulary() const { return impl_->core.vocabulary; }
json Service::submit_job(const JobRequest& request, const std::optional<std::string>& idempotency_key,
                         const std::string& canonical_body) {
    return impl_->jobs.submissions.submit_job(request, idempotency_key, canonical_body);
}
json Service::estimate_job(const JobRequest& request) { return impl_->jobs.submissions.estimate_job(request); }
json Service::get_job(const std::string& id) { return impl_->jobs.objects.get_job(id); }
void Service::list_jobs(const JobFilter& filter, const TextSink& write) {
    impl_->jobs.objects.list_jobs(filter, write);
}
Service::Cancelled Service::cancel_job(const std::string& id) {
    return impl_->jobs.cancellations.cancel_job(id, false);
}
Service::Cancelled Service::purge_job(const std::string& id) { return impl_->jobs.cancellations.cancel_job(id, true); }
json Service::change_job(const std::string& id, const json& body) { return impl_->jobs.changes.change_job(id, body); }
json Service::repeat_job(const std::string& id) { return impl_->jobs.changes.repeat_job(id); }
json Service::retry_job(const std::string& id) { return impl_->jobs.changes.retry_job(id); }
json Service::extend_job(const std::string& id, const json& body) { return impl_->jobs.changes.extend_job(id, body); }
json Service::merge_jobs(const json& body, const std::optional<std::string>& idempotency_key) {
    return impl_->jobs.merges.merge_jobs(body, idempotency_key);
}
json Service::measure(const json& body) { return impl_->jobs.errors.measure(body); }
Artefact Service::image(const std::string& id, const std::string& precision) {
    return impl_->jobs.artefacts.image(id, precision);
}
Artefact Service::preview(const std::string& id, const PreviewWanted& wanted) {
    return impl_->jobs.artefacts.preview(id, wanted);
}
Artefact Service::pixels(const std::string& id, const std::string& layer, const std::string& precision) {
    return impl_->jobs.artefacts.pixels(id, layer, precision);
}
Artefact Service::film(const std::string& id) { return impl_->jobs.artefacts.film(id); }
Artefact Service::difference(const std::string& id) { return impl_->jobs.errors.difference(id); }
Artefact Service::flip(const std::string& id, const std::string& layer, const std::string& range) {
    return impl_->jobs.errors.flip(id, layer, range);
}
Artefact Service::error_map(const std::string& id, const std::string& layer) {
    return impl_->jobs.errors.error_map(id, layer);
}
Artefact Service::flip_map(const std::string& image, const std::string& reference, const std::string& layer,
                           const std::string& range, const std::string& precision) {
    return impl_->jobs.errors.flip_map(image, reference, layer, range, precision);
}
Artefact Service::curve(const std::string& id) { return impl_->jobs.artefacts.curve_file(id); }
Artefact Service::statistics(const std::string& id) { return impl_->jobs.artefacts.statistics(id); }
Artefact Service::method_artefact(const std::string& id, const std::string& name) {
    return impl_->jobs.artefacts.method_artefact(id, name);
}
Artefact Service::log(const std::string& id) { return impl_->jobs.artefacts.log(id); }
json Service::submit_comparison(const ComparisonRequest& request, const std::optional<std::string>& idempotency_key) {
    return impl_->comparisons.submit_comparison(request, idempotency_key);
}
json Service::get_comparison(const std::string& id) {
    impl_->biases.settle(id);
    return impl_->comparisons.get_comparison(id);
}
json Service::change_comparison(const std::string& id, const json& body) {
    impl_->comparisons.change_comparison(id, body);
    return get_comparison(id);
}
Page Service::list_comparisons(uint32_t limit, const std::string& cursor) {
    return impl_->comparisons.list_comparisons(limit, cursor);
}
Service::Cancelled Service::cancel_comparison(const std::string& id) {
    return impl_->comparisons.cancel_comparison(id, false);
}
Service::Cancelled Service::purge_comparison(const std::string& id) {
    return impl_->comparisons.cancel_comparison(id, true);
}

json Service::submit_sequence(const SequenceRequest& request, const std::optional<std::string>& idempotency_key) {
    return impl_->sequences.submit_sequence(request, idempotency_key);
}
json Service::estimate_sequence(const SequenceRequest& request) { return impl_->sequences.estimate_sequence(request); }
json Service::get_sequence(const std::string& id, bool with_frames) {
    return impl_->sequences.get_sequence(id, with_frames);
}
Page Service::list_sequences(uint32_t limit, const std::string& cursor) {
    return impl_->sequences.list_sequences(limit, cursor);
}
json Service::sequence_errors(const std::string& id, const std::string& first, const std::string& second,
                              const std::string& layer) {
    return impl_->sequence_errors.errors(id, first, second, layer);
}
Artefact Service::sequence_zip(const std::string& id, const std::string& images) {
    return impl_->sequence_files.frames_zip(id, images);
}
Artefact Service::sequence_video(const std::string& id, const VideoWanted& wanted) {
    return impl_->sequence_files.video(id, wanted);
}
Artefact Service::sequence_html(const std::string& id, const SequenceReportWanted& wanted) {
    return impl_->sequence_reports.html(id, wanted);
}
Service::Cancelled Service::cancel_sequence(const std::string& id) {
    return impl_->sequences.cancel_sequence(id, false);
}
Service::Cancelled Service::purge_sequence(const std::string& id) { return impl_->sequences.cancel_sequence(id, true); }

json Service::estimate_comparison(const ComparisonRequest& request) {
    return impl_->comparisons.estimate_comparison(request);
}
Artefact Service::bias_map(const std::string& id, uint32_t row, const std::string& layer) {
    return impl_->biases.map_json(id, row, layer);
}
Artefact Service::bias_picture(const std::string& id, uint32_t row, const std::string& layer) {
    return impl_->biases.map_picture(id, row, layer);
}
Artefact Service::comparison_json(const std::string& id) {
    impl_->biases.settle(id);
    return impl_->reports.comparison_json(id);
}
Artefact Service::comparison_csv(const std::string& id) { return impl_->reports.comparison_csv(id); }
Artefact Service::comparison_html(const std::string& id) {
    impl_->biases.settle(id);
    return impl_->reports.comparison_html(id);
}
Page Service::devices() { return impl_->system.devices(); }
json Service::make_backup() { return impl_->backups.make(); }
json Service::get_backup(const std::string& id) { return impl_->backups.get(id); }
Artefact Service::backup_file(const std::string& id, const std::string& path) { return impl_->backups.file(id, path); }
json Service::remove_backup(const std::string& id) { return impl_->backups.remove(id); }
json Service::status() { return impl_->system.status(); }
Readiness Service::readiness() const { return impl_->system.readiness(); }
std::string Service::metrics_text() { return impl_->system.metrics_text(); }
EventHub& Service::events() { return impl_->core.events; }
Metrics& Service::metrics() { return impl_->core.metrics; }
const Options& Service::options() const { return impl_->core.options; }
void Service::stop() { impl_->processes.stop(); }

}  // namespace photond
