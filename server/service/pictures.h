#pragma once
// Pictures that no result depends on: thumbnails and previews of scenes, maps of errors. While a job renders on the
// host's processors they are drawn beside it, by a helper in the lowest scheduling class with one thread, and no more
// of them than the job puts up with (PictureLine): its clock must not notice. Else the helper that everybody waits for
// draws them, with all cores.

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "server/service/artefact_files.h"
#include "server/service/picture_line.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"
#include "server/workers/helper.h"

namespace photond {

/// Who draws a picture, and how long it may take.
struct Draughtsman {
    Helper& helper;
    std::optional<double> most_seconds;  // of rendering by the clock; none where that says nothing
};

/// All without the lock.
class Pictures {
public:
    Pictures(ServiceCore& core, ArtefactFiles& artefact_files);
    ~Pictures();
    Pictures(const Pictures&) = delete;
    Pictures& operator=(const Pictures&) = delete;

    /// Writes the picture at `path`; returns its headers.
    using Draw =
        std::function<std::map<std::string, std::string>(const Draughtsman& by, const std::filesystem::path& path)>;
    /// The picture under `key` in the cache, drawn where it is not there; what `draw` holds lives until then. Waits for
    /// the helper. Throws TryLater when it is not drawn within kPatience because a job renders (of a client that
    /// asks again: at once), and what `draw` throws.
    /// Whoever asks again then, by the same `name` (say, of a job's newest picture), gets what was drawn meanwhile.
    Artefact picture(const std::string& name, const std::string& key, const std::string& media_type, const Draw& draw);
    /// The same, always by the helper beside jobs: of what nobody waits for, and may take long.
    Artefact drawn_beside(const std::string& name, const std::string& key, const std::string& media_type,
                          const Draw& draw);
    /// Whether `draw` was called, as no job renders on the host's processors.
    bool drawn_at_once(const std::function<void(const Draughtsman& by)>& draw);

    /// `process`: what all processes of the daemon have alike.
    void start(ProcessOptions process, std::function<void(const ProcessExit&)> exited);
    void begin_stop(SteadyClock::time_point deadline);
    void join();

    /// Pictures to be drawn beside a job, the one at hand included.
    size_t waiting() const;
    /// Of the helper that draws them; null before start().
    const Helper* background() const { return background_.get(); }

    static constexpr std::chrono::seconds kPatience{5};
    static constexpr int kMostCallers = 4;  // that wait: others need the threads that answer

private:
    Artefact drawn_beside(const std::string& name, const std::function<Artefact()>& draw);
    void run();

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
    std::mutex at_once_;  // one picture at a time: a job may begin between two
    std::unique_ptr<Helper> background_;
    mutable std::mutex mutex_;  // guards what follows
    std::condition_variable changed_;
    PictureLine line_;
    int callers_ = 0;  // that wait
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace photond
