#pragma once
// The façade the HTTP routes call: everything the daemon does, without a word of HTTP. Objects are JSON as on the wire
// (protocol.md, "Shapes"); failures are photond::Error. All methods are thread-safe; those that wait for a process say
// so.

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "protocol/comparison.h"
#include "protocol/error.h"
#include "protocol/job.h"
#include "protocol/sequence.h"
#include "server/events.h"
#include "server/metrics.h"
#include "server/options.h"
#include "server/service/service_types.h"

namespace photond {

class Service {
public:
    /// Opens the store (throws photond::Error when it cannot), queues again what was running, starts the processes.
    explicit Service(Options options);
    /// stop()s if that has not been done.
    ~Service();
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    // --- scenes
    // -------------------------------------------------------------------------------------------------------
    /// A fresh name in the folder where uploads are spooled, which is on the store's own file system and emptied at
    /// start. Call check_disk() before spooling: NoSpace when `bytes` more would go below the reserve.
    std::filesystem::path make_spool_path();
    void check_disk(uint64_t bytes) const;

    /// Waits for the helper's verdict: BadScene with JSON pointers into the glTF.
    Added add_scene(SceneUpload upload);
    /// Uploaded scenes, then built-in ones; or the built-in ones of a family (builtin_scenes.h), which are listed only
    /// so: UnknownName for one that there is not.
    Page list_scenes(const std::string& family, uint32_t limit, const std::string& cursor);
    nlohmann::json get_scene(const std::string& id_or_name);
    /// Waits for the helper the first time. TryLater while a job renders and it is not drawn soon (service/pictures.h),
    /// as all pictures below that say so.
    Artefact thumbnail(const std::string& id_or_name);
    /// A PNG, made anew each time and kept nowhere but while a job renders; waits for the helper, which keeps the scene
    /// ready for the next one. UnknownName at /camera. TryLater.
    DrawnPreview scene_preview(const std::string& id_or_name, const ScenePreview& wanted);
    /// The scene as a file of renderer/scene/baked_scene.h. Waits for the helper the first time. OutOfMemory, NoSpace
    /// and TimedOut where it is too large to be made.
    Artefact baked_scene(const std::string& id_or_name);
    /// WrongState while a job that is not over uses it, and for a built-in one. Returns the object deleted.
    nlohmann::json delete_scene(const std::string& id_or_name);

    // --- images
    // -------------------------------------------------------------------------------------------------------
    /// `media_type` image/x-exr or image/vnd.radiance (or another spelling of them, else WrongMediaType); waits for the
    /// helper. The object: {"id", "media_type", "width", "height", "channels", "bytes", "layers": [{"name",
    /// "channels"}]}.
    Added add_image(const std::filesystem::path& spooled, const std::string& media_type);
    nlohmann::json get_image(const std::string& id);
    /// The file as uploaded.
    Artefact image_file(const std::string& id);
    /// One of its layers as pixels() gives a job's. UnknownName at /layer where it has none of that name.
    Artefact image_pixels(const std::string& id, const std::string& layer, const std::string& precision);

    // --- jobs
    // ---------------------------------------------------------------------------------------------------------
    /// For parse_job_request(): methods, layers and limits of this daemon.
    const JobVocabulary& vocabulary() const;
    /// Durable when it returns. `canonical_body` is what an idempotency key is bound to (to_json(request).dump() will
    /// do). QueueFull, Unavailable (stopping), NoSpace, UnknownName (scene, camera, environment), DeviceUnavailable,
    /// OutOfMemory, IdempotencyMismatch.
    nlohmann::json submit_job(const JobRequest& request, const std::optional<std::string>& idempotency_key,
                              const std::string& canonical_body);
    /// {"memory_bytes", "seconds"} after the same checks of the request; seconds is null while the method has rendered
    /// nothing here. Waits for the helper the first time a built-in scene is asked about.
    nlohmann::json estimate_job(const JobRequest& request);
    /// An item of "attempts": {"attempt", "device", "started", "finished", "outcome": "running", "succeeded", "failed",
    /// "cancelled", "stopped", "lost", "crashed", "hung", "device_lost", "out_of_memory", "no_space" or "timed_out",
    /// "reason", "passes_done"} and, when it is over, {"device_shared", "host_shared"}.
    nlohmann::json get_job(const std::string& id);
    /// A Page of jobs, or of their summaries with "total" beside it, as text: other requests are answered between its
    /// pieces.
    void list_jobs(const JobFilter& filter, const TextSink& write);
    using Cancelled = photond::Cancelled;
    Cancelled cancel_job(const std::string& id);
    /// Removes the job and its files; a running one is cancelled first and removed when its worker has let go of it.
    Cancelled purge_job(const std::string& id);
    /// `body`: {"priority": -100..100}. A job that waits moves in the queue, one that runs keeps it for its next
    /// attempt; WrongState for one that is over. Durable when it returns.
    nlohmann::json change_job(const std::string& id, const nlohmann::json& body);
    nlohmann::json retry_job(const std::string& id);
    /// The same request as a new job, which is returned; one of a comparison takes its place there where that was
    /// disturbed. WrongState where the job, or a repeat of it, is not over; else as submit_job().
    nlohmann::json repeat_job(const std::string& id);
    /// More passes on the film of a succeeded or cancelled job: `body` is {"stop": ...}, counted from the film's first
    /// pass, so that saying it twice does no harm. WrongState in other states, Conflict at /stop when the film meets
    /// it already.
    nlohmann::json extend_job(const std::string& id, const nlohmann::json& body);
    /// `body`: {"jobs": [ids]}, parts of one image. A new job whose film is all their passes; faults at /jobs/i. Waits
    /// for the helper.
    nlohmann::json merge_jobs(const nlohmann::json& body, const std::optional<std::string>& idempotency_key);
    /// `body`: {"image", "reference": "job:ID" or "image:ID", "metrics": [names]}; {"metrics", "reference_error",
    /// "notes"}. Waits for the helper.
    nlohmann::json measure(const nlohmann::json& body);

    // Artefacts; they wait for the helper (and, while the job runs, for the pass at hand) unless they are in the cache.
    // `precision` is "float" or "half", else OutOfRange. NotFound when the job ended without a film.
    Artefact image(const std::string& id, const std::string& precision);
    using PreviewWanted = photond::PreviewWanted;
    using VideoWanted = photond::VideoWanted;
    using SequenceReportWanted = photond::SequenceReportWanted;
    Artefact preview(const std::string& id, const PreviewWanted& wanted);
    /// Raw little-endian pixels, row 0 at the top; `layer` empty or "beauty", or a layer's name. Headers
    /// X-Image-Width, X-Image-Height, X-Image-Channels.
    Artefact pixels(const std::string& id, const std::string& layer, const std::string& precision);
    /// Pending until the job is over; NotFound when it ended without statistics.
    Artefact statistics(const std::string& id);
    /// What the method left beside the image, by a name of all_artefacts(). Pending until the job is over; NotFound,
    /// saying how to ask for it, when the job has none.
    Artefact method_artefact(const std::string& id, const std::string& name);
    /// Of a job with a reference; NotFound, with the reason, where either film is missing. EXR of x - r by layer; PNG
    /// of the FLIP map (`range` "ldr" or "hdr") and of each pixel's relative error, which throw TryLater.
    Artefact difference(const std::string& id);
    Artefact flip(const std::string& id, const std::string& layer, const std::string& range);
    Artefact error_map(const std::string& id, const std::string& layer);
    /// The FLIP map of any two, each "job:ID" or "image:ID", as pixels of one channel; X-Flip-Mean beside the headers
    /// of pixels(). Pending while a job has no film; UnknownName, Conflict for unlike sizes, each with its pointer.
    /// TryLater.
    Artefact flip_map(const std::string& image, const std::string& reference, const std::string& layer,
                      const std::string& range, const std::string& precision);
    /// text/csv: seconds, passes, photons and every metric measured; so far while it runs.
    Artefact curve(const std::string& id);
    /// The film itself, in the format of film_file.h.
    Artefact film(const std::string& id);
    /// What happened to the job, attempt by attempt; text/plain.
    Artefact log(const std::string& id);

    // --- comparisons
    // --------------------------------------------------------------------------------------------------
    /// Durable, with all its jobs, when it returns; all of them are accepted or none. Throws as submit_job() does.
    nlohmann::json submit_comparison(const ComparisonRequest& request,
                                     const std::optional<std::string>& idempotency_key);
    /// What submit_comparison() would queue, after all its checks: {"jobs", "memory_bytes", "seconds",
    /// "reference_seconds", "entries": [{"label", "parameters", "memory_bytes", "seconds"}]}; seconds are null where
    /// they cannot be told. Waits for the helper the first time a built-in scene is asked about.
    nlohmann::json estimate_comparison(const ComparisonRequest& request);
    nlohmann::json get_comparison(const std::string& id);
    /// {"title", "notes"}, or one of them (protocol/comparison_remarks.h). Returns the comparison.
    nlohmann::json change_comparison(const std::string& id, const nlohmann::json& body);
    /// Without jobs and tables.
    Page list_comparisons(uint32_t limit, const std::string& cursor);
    /// Cancels its jobs that are not over, and the reference made for it where nobody else waits for that.
    Cancelled cancel_comparison(const std::string& id);
    /// Removes its jobs and their files too; what runs when its worker has let go of it.
    Cancelled purge_comparison(const std::string& id);
    /// Where a row of its table is biased (renderer/error/welch_map.h), as JSON and as a picture. NotFound, with the
    /// reason, where that cannot be told; UnknownName at /layer; TryLater.
    Artefact bias_map(const std::string& id, uint32_t row, const std::string& layer);
    Artefact bias_picture(const std::string& id, uint32_t row, const std::string& layer);
    /// get_comparison() and every curve.
    Artefact comparison_json(const std::string& id);
    Artefact comparison_csv(const std::string& id);
    /// A page that needs nothing beside itself; waits for the helper. Of a comparison that is not over it shows what is
    /// there. Its header Content-Security-Policy permits exactly its own script and style.
    Artefact comparison_html(const std::string& id);

    // --- sequences
    // --------------------------------------------------------------------------------------------------
    /// Durable, with all its frames, when it returns; all of them are accepted or none. Throws as submit_job() does.
    nlohmann::json submit_sequence(const SequenceRequest& request, const std::optional<std::string>& idempotency_key);
    /// What submit_sequence() would queue, after all its checks: {"frames", "memory_bytes", "disk_bytes", "seconds",
    /// "warning"}. Waits for the helper the first time a built-in scene is asked about.
    nlohmann::json estimate_sequence(const SequenceRequest& request);
    nlohmann::json get_sequence(const std::string& id, bool with_frames);
    /// Without frames.
    Page list_sequences(uint32_t limit, const std::string& cursor);
    /// Its errors by frame against two other sequences of the same frames (SequenceErrors::errors). Waits for the
    /// helper.
    nlohmann::json sequence_errors(const std::string& id, const std::string& first, const std::string& second,
                                   const std::string& layer);
    /// A ZIP of its frames' images, exr or png, of those that have succeeded so far. Waits for the helper. OutOfRange.
    Artefact sequence_zip(const std::string& id, const std::string& images);
    Artefact sequence_video(const std::string& id, const VideoWanted& wanted);
    Artefact sequence_html(const std::string& id, const SequenceReportWanted& wanted);
    /// Cancels its frames that are not over.
    Cancelled cancel_sequence(const std::string& id);
    /// Removes its frames and their files too; what runs when its worker has let go of it.
    Cancelled purge_sequence(const std::string& id);

    // --- system
    // -------------------------------------------------------------------------------------------------------
    /// The CPU and all GPUs of the machine; what "served" says is what jobs can be rendered on. Waits for the process
    /// that lists them the first time.
    Page devices();
    /// {"version", "uptime_seconds", "ready", "queue": {"queued", "running"}, "workers": [{"device", "device_name",
    /// "state", "pid", "job", "restarts", "resident_bytes", "memory_limit_bytes"}], "pictures": {"waiting", "pid",
    /// "restarts", "resident_bytes"}, "helpers": [{"name", "state", "busy_seconds", "pid", "restarts",
    /// "resident_bytes"}], "store" (store_upkeep.h), "disk_free_bytes", "resident_bytes", "event_clients", "totals":
    /// {"jobs", "passes", "pixels", "render_seconds", "rays", "photons"}}.
    nlohmann::json status();
    /// The store is open, every worker and the helpers have answered, and the helper that people wait for is not at one
    /// request for long. Takes no lock.
    Readiness readiness() const;
    std::string metrics_text();

    // --- backups
    // ------------------------------------------------------------------------------------------------------
    /// All that would have to be put back, as it is at one moment, while jobs run on: {"id", "created", "store",
    /// "bytes", "files": [{"path", "bytes"}]}. It is kept until remove_backup(), the next one or the daemon's end.
    /// NoSpace.
    nlohmann::json make_backup();
    nlohmann::json get_backup(const std::string& id);
    Artefact backup_file(const std::string& id, const std::string& path);
    nlohmann::json remove_backup(const std::string& id);

    EventHub& events();
    Metrics& metrics();
    const Options& options() const;

    /// No new jobs from now on (Unavailable); running jobs save their film and go back to the queue; processes end.
    /// Returns within limits.shutdown_grace_seconds.
    void stop();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace photond
