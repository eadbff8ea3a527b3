#pragma once
// What the daemon and a worker that renders say to each other (message_channel.h). Files are named by absolute paths
// inside the data directory; the writer writes beside, fsyncs and renames. "job" and "attempt" are those of the order:
// the daemon ignores what comes with others than its own.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "protocol/message_json.h"
#include "protocol/message_parts.h"

namespace photond {

/// Where the worker leaves an artefact of the method, beside the film of the same attempt.
inline std::filesystem::path artefact_path(const std::filesystem::path& film, std::string_view name) {
    return film.string().append(".").append(name);
}

// --- Worker -> daemon. A helper says the first two as well.

/// Sent once, when the process is ready to take work.
struct HelloMessage {
    static constexpr const char* kType = "hello";
    int64_t pid = 0;
    nlohmann::json device;  // protocol.md, "Shapes": with "lacks" and "limits"
    FileAccess file_access;

    void visit(MessageVisitor& visitor) {
        visitor.member("pid", pid);
        visitor.or_null("device", device);
        visitor.member("file_access", file_access);
    }
};

/// Every second, from a thread of its own.
struct HeartbeatMessage {
    static constexpr const char* kType = "heartbeat";
    uint64_t resident_bytes = 0;

    void visit(MessageVisitor& visitor) { visitor.member("resident_bytes", resident_bytes); }
};

struct StartedMessage {
    static constexpr const char* kType = "started";
    std::string job;
    int64_t attempt = 0;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
    }
};

/// The error of the film so far.
struct ErrorNow {
    std::string metric;
    /// None: it is not finite, for which JSON has no number, or the root of a figure below 0.
    std::optional<double> value;
    std::optional<std::vector<double>> interval;  // {least, greatest}: of a figure against two films

    void visit(MessageVisitor& visitor) {
        visitor.member("metric", metric);
        visitor.or_null("value", value);
        visitor.or_null("interval", interval);
    }
};

/// Sent while a job runs, at most four times a second.
struct ProgressMessage {
    static constexpr const char* kType = "progress";
    std::string job;
    int64_t attempt = 0;
    uint32_t passes_done = 0;  // of the film, whatever attempt rendered them
    double progress = 0;       // 0 to 1
    double seconds = 0;        // of rendering, on the job's clock
    std::optional<ErrorNow> error_now;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
        visitor.member("passes_done", passes_done);
        visitor.member("progress", progress);
        visitor.member("seconds", seconds);
        visitor.or_null("error_now", error_now);
    }
};

/// New points of the job's curve, in their order; a job that goes on from a film sends those it had first.
struct CurveMessage {
    static constexpr const char* kType = "curve";
    std::string job;
    int64_t attempt = 0;
    std::vector<nlohmann::json> points;  // of a curve: protocol.md, "Shapes"
    std::optional<ErrorNow> error_now;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
        visitor.member("points", points);
        visitor.or_null("error_now", error_now);
    }
};

/// Says that the film so far is on disk: at a SnapshotMessage's path after that message; at the order's `film` every
/// `save_seconds` and before the worker stops.
struct FilmSavedMessage {
    static constexpr const char* kType = "film_saved";
    std::string job;
    int64_t attempt = 0;
    std::filesystem::path path;
    uint32_t passes_done = 0;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
        visitor.member("path", path);
        visitor.member("passes_done", passes_done);
    }
};

/// What one attempt has rendered, without what earlier attempts left.
struct RenderedWork {
    struct Rays {
        uint64_t camera = 0, bounce = 0, shadow = 0, photon = 0;

        void visit(MessageVisitor& visitor) {
            visitor.member("camera", camera);
            visitor.member("bounce", bounce);
            visitor.member("shadow", shadow);
            visitor.member("photon", photon);
        }
    };
    uint32_t passes = 0;
    double seconds = 0;
    Rays rays;
    uint64_t photons = 0;  // emitted

    void visit(MessageVisitor& visitor) {
        visitor.member("passes", passes);
        visitor.member("seconds", seconds);
        visitor.member("rays", rays);
        visitor.member("photons", photons);
    }
};

/// What a job wanted of the host's processors while its clock ran, and what it had: "cores" of its statistics. Of all
/// its attempts; empty where the kernel does not say.
struct CoreUse {
    double processor_seconds = 0;  // of all its threads
    /// How long its threads were ready to run and waited for a processor, for whatever reason: more threads than
    /// processors wait for each other.
    std::optional<double> run_delay_seconds;
    std::optional<double> host_busy_outside_seconds;  // of processors, in other processes
    std::optional<double> host_steal_seconds;         // of processors, taken by the machine that the host is a guest of
    std::optional<double> pressure_seconds;           // in which some thread of the host waited for a processor
    // These follow from the others:
    std::optional<double> lost_seconds;        // of processors, to other processes
    std::optional<double> share;               // of the processor time that it wanted
    std::optional<double> clock_lost_seconds;  // by which its clock is too long, at most

    /// The value before a clock has run.
    static CoreUse of_nothing();
    CoreUse& operator+=(const CoreUse& other);
    /// Fills in what follows, for a job whose clock shows so much, on a host of so many processors.
    void derive(double clock_seconds, unsigned processors);
    void visit(MessageVisitor& visitor) {
        visitor.member("processor_seconds", processor_seconds);
        visitor.or_null("run_delay_seconds", run_delay_seconds);
        visitor.or_null("host_busy_outside_seconds", host_busy_outside_seconds);
        visitor.or_null("host_steal_seconds", host_steal_seconds);
        visitor.or_null("pressure_seconds", pressure_seconds);
        visitor.or_null("lost_seconds", lost_seconds);
        visitor.or_null("share", share);
        visitor.or_null("clock_lost_seconds", clock_lost_seconds);
    }
};

/// The last message of an attempt.
struct FinishedMessage {
    static constexpr const char* kType = "finished";
    std::string job;
    int64_t attempt = 0;
    std::string state = "failed";  // or "succeeded" or "cancelled"
    uint32_t passes_done = 0;
    double seconds = 0;
    std::optional<std::filesystem::path> film;  // the order's, where a pass was finished and the job did not fail
    nlohmann::json statistics;                  // protocol.md, "Shapes"; or null
    std::optional<CoreUse> cores;               // none where the attempt failed
    std::optional<RenderedWork> rendered;       // none where the attempt failed
    nlohmann::json curve;                       // list of points or null
    std::optional<ErrorNow> error_now;
    std::vector<std::string> artefacts;  // MethodInfo::artefacts that lie at artefact_path(); none where `stopping`
    std::optional<Failure> failure;
    std::vector<std::string> log;
    bool stopping = false;  // the job ended because of StopMessage

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
        visitor.member("state", state);
        visitor.member("passes_done", passes_done);
        visitor.member("seconds", seconds);
        visitor.or_null("film", film);
        visitor.or_null("statistics", statistics);
        visitor.or_null("cores", cores);
        visitor.or_null("rendered", rendered);
        visitor.or_null("curve", curve);
        visitor.or_null("error_now", error_now);
        visitor.member("artefacts", artefacts);
        visitor.or_null("failure", failure);
        visitor.member("log", log);
        visitor.member("stopping", stopping);
    }
};

/// The GPU stopped answering; the process then ends with kDeviceLostStatus.
struct DeviceLostMessage {
    static constexpr const char* kType = "device_lost";
    std::string job;
    int64_t attempt = 0;
    std::string reason;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
        visitor.member("reason", reason);
    }
};

/// All of this machine, by --device list.
struct DevicesMessage {
    static constexpr const char* kType = "devices";
    std::vector<nlohmann::json> items;  // objects as HelloMessage::device

    void visit(MessageVisitor& visitor) { visitor.member("items", items); }
};

/// Of a worker that has work to do or is ready for it.
using WorkerMessage = std::variant<HelloMessage, StartedMessage, ProgressMessage, CurveMessage, FilmSavedMessage,
                                   FinishedMessage, DeviceLostMessage>;
/// Empty for one of a type that is none of these. Throws Error where it cannot be read.
std::optional<WorkerMessage> read_worker_message(const nlohmann::json& message);

// --- Daemon -> worker

/// The order to render a job.
struct RenderMessage {
    static constexpr const char* kType = "render";
    struct Environment {
        std::filesystem::path path;  // of the image

        void visit(MessageVisitor& visitor) { visitor.member("path", path); }
    };
    struct Limits {
        uint64_t memory_bytes = UINT64_MAX;
        uint32_t threads = 0;  // 0: all the worker has

        void visit(MessageVisitor& visitor) {
            visitor.or_default("memory_bytes", memory_bytes);
            visitor.or_default("threads", threads);
        }
    };
    /// The frame of the same sequence that this one follows.
    struct FrameBefore {
        std::filesystem::path film;
        double time = 0;  // of the animation [s]

        void visit(MessageVisitor& visitor) {
            visitor.member("film", film);
            visitor.member("time", time);
        }
    };
    std::string job;
    int64_t attempt = 0;
    nlohmann::json request;  // the job, as job.h echoes it
    SceneSource scene;
    std::optional<Environment> environment;
    std::filesystem::path film;  // to write
    std::string origin;          // written down in it: FilmFacts::origin
    /// Film of the same job to go on from. One that is damaged or of something else is named in the log, and the job
    /// begins anew.
    std::optional<std::filesystem::path> resume;
    /// None: it is the first, or frames stand alone. What cannot be followed is named in the log, and the frame begins
    /// as the first one does.
    std::optional<FrameBefore> before;
    std::optional<ReferenceSource> reference;
    std::string streams = "job";         // or "reference": the random numbers it draws (RandomStreams)
    std::optional<double> save_seconds;  // the least time between two savings of the film; none: it is not saved
    Limits limits;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("attempt", attempt);
        visitor.or_null("request", request);
        visitor.member("scene", scene);
        visitor.or_null("environment", environment);
        visitor.member("film", film);
        visitor.or_default("origin", origin);
        visitor.or_null("resume", resume);
        visitor.or_null("before", before);
        visitor.or_null("reference", reference);
        visitor.or_default("streams", streams);
        visitor.or_null("save_seconds", save_seconds);
        visitor.or_default("limits", limits);
    }
};

/// Save the film so far after the pass at hand: answered by FilmSavedMessage or, when the job ends first, by its
/// FinishedMessage alone.
struct SnapshotMessage {
    static constexpr const char* kType = "snapshot";
    std::string job;
    std::filesystem::path path;

    void visit(MessageVisitor& visitor) {
        visitor.member("job", job);
        visitor.member("path", path);
    }
};

/// End the job; its film so far is saved.
struct CancelMessage {
    static constexpr const char* kType = "cancel";
    std::string job;

    void visit(MessageVisitor& visitor) { visitor.member("job", job); }
};

/// Save the film of the running job, report it cancelled and `stopping`, and end with status 0. A helper ends at once.
struct StopMessage {
    static constexpr const char* kType = "stop";

    void visit(MessageVisitor&) {}
};

using DaemonMessage = std::variant<RenderMessage, SnapshotMessage, CancelMessage, StopMessage>;
/// Empty for one of a type that is none of these. Throws Error where it cannot be read.
std::optional<DaemonMessage> read_daemon_message(const nlohmann::json& message);

}  // namespace photond
