#pragma once
// Scene -> method -> film -> result: one job from its order to what it leaves. Around the loop over its passes
// (pass_loop.h) it goes on from saved films and saves them (film_saver.h), follows the error (error_follower.h) and
// sends what the daemon wants to hear (film_so_far.h).

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "protocol/worker_messages.h"
#include "renderer/core/cancel.h"
#include "server/worker/device.h"
#include "server/worker/error_follower.h"
#include "server/worker/error_statistics.h"
#include "server/worker/film_history.h"
#include "server/worker/film_saver.h"
#include "server/worker/film_so_far.h"
#include "server/worker/pass_loop.h"
#include "server/worker/render_meters.h"
#include "server/worker/render_order.h"
#include "server/worker/scene_cache.h"
#include "server/worker/statistics.h"

namespace photond {

/// What other threads may ask of a running job.
class JobControl {
public:
    CancelToken cancel;
    std::atomic<bool> stopping{false};  // cancelled because the worker is to end
    FilmRequests film_so_far;
};

/// What will be said in the end; filled as the job goes on, so that a failure keeps what was true before it.
struct JobReport : FinishedMessage {
    std::vector<std::filesystem::path> artefact_files;
};

class RenderJob {
public:
    /// Called from two threads (film_so_far.h), also at once.
    using Send = std::function<void(const nlohmann::json& message)>;

    /// Borrows everything. Throws photond::Error with pointers into the request for parameters that are refused.
    RenderJob(const RenderOrder& order, JobControl& control, SceneCache& scenes, const Device& device,
              JobReport& report, const Send& send);

    /// Throws photond::Error for what the job or its files cannot have; the report then holds what was done.
    void run();

private:
    void load_scene();
    /// Tells the method what the frame before left, where the order names one that can be followed.
    void follow_frame_before();
    /// What the device holds for other jobs' scenes.
    void note_idle_device_memory();
    /// What it holds, and held at most, for this job; empty on the CPU.
    std::optional<DeviceMemoryUse> device_memory() const;
    void prepare_measuring();
    /// The film of an earlier attempt, where there is one that this job may go on with; otherwise the log says why
    /// not. Its statistics and its curve become this job's.
    std::optional<Film> film_to_go_on_with();
    /// The method, or where the shutter is open one that makes it anew for each pass.
    std::unique_ptr<Method> make_passes();
    RenderContext context();
    PassLoop::Result render();
    bool after_pass(const Film& film, double seconds);
    void finish(const PassLoop::Result& result);

    FilmHistory history(double seconds);
    /// What all attempts had of the processors.
    CoreUse core_use();
    void save(const Film& film, double seconds, bool tell);
    void tell_saved(const std::filesystem::path& path, uint32_t passes);
    void save_artefacts();
    /// Sends the curve's points from that one on.
    void send_curve(size_t first);
    void tell_progress(const Film& film, double seconds);
    template <class... Arguments>
    void log(const char* format, Arguments... arguments);

    const RenderOrder& order_;
    JobControl& control_;
    SceneCache& scenes_;
    const Device& device_;
    JobReport& report_;
    const Send& send_;

    const std::unique_ptr<Method> method_;  // checked before anything is loaded
    Stats stats_;
    MemoryBudget budget_;
    RenderMeters meters_;
    uint64_t baseline_bytes_ = 0;
    std::shared_ptr<const ReadyScene> ready_;
    std::map<std::string, uint64_t> idle_device_structures_;
    std::optional<FilmErrors> errors_;
    std::optional<ErrorFollower> follower_;
    std::optional<FilmSaver> saver_;
    std::optional<FilmSoFar> so_far_;               // while passes are rendered
    double seconds_before_ = 0;                     // of the film that this job goes on with
    uint32_t resumed_passes_ = 0;                   // likewise
    Counts counts_before_;                          // likewise
    CoreUse cores_before_ = CoreUse::of_nothing();  // likewise
    bool met_before_ = false;                       // its target, likewise
    std::vector<Skipped> skipped_before_;
    std::string left_before_;  // of the film that this job goes on with: SavedFilm::left
};

}  // namespace photond
