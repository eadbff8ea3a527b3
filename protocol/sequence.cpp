#include "protocol/sequence.h"

#include <cmath>

#include "protocol/camera_path.h"
#include "protocol/param_json.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr double kMostSeconds = 1e9, kMostFramesASecond = 1e6, kLeastFramesASecond = 1e-6;

/// What is a sequence's own; the other members are a job's.
constexpr const char* kOwn[] = {"from", "to", "fps", "frames", "noise", "camera_path"};

struct Moments {
    double from = 0, fps = 24;
    uint32_t frames = 0;

    double at(uint32_t frame) const { return from + frame / fps; }
};

Moments read_moments(ObjectReader& reader) {
    Moments moments;
    BodyFaults& faults = reader.faults();
    const size_t before = faults.size();
    if (const auto from = reader.number("from", {-kMostSeconds, kMostSeconds, "s"})) moments.from = *from;
    if (const auto fps = reader.number("fps", {kLeastFramesASecond, kMostFramesASecond, "frames a second"}))
        moments.fps = *fps;
    const auto to = reader.number("to", {-kMostSeconds, kMostSeconds, "s"});
    const auto frames = reader.integer("frames", 1, int64_t{kMaxFrames});
    if (faults.size() != before) return moments;
    if (to.has_value() == frames.has_value()) {
        faults.add(to ? ErrorCode::Conflict : ErrorCode::MissingField, reader.at("frames"),
                   "is required, or else to: the time after which no frame comes");
    } else if (frames) {
        moments.frames = static_cast<uint32_t>(*frames);
    } else if (!(*to >= moments.from)) {
        faults.add(ErrorCode::OutOfRange, reader.at("to"), "must not be before from");
    } else {
        // A moment that is `to` but for rounding is still to come.
        const double count = std::floor((*to - moments.from) * moments.fps + 1e-6) + 1;
        if (count > static_cast<double>(kMaxFrames))
            faults.add(ErrorCode::OutOfRange, reader.at("to"),
                       "makes " + number_text(count) + " frames, a sequence has at most " + std::to_string(kMaxFrames));
        else
            moments.frames = static_cast<uint32_t>(count);
    }
    if (moments.frames > 0 && !(moments.at(moments.frames - 1) <= kMostSeconds))
        faults.add(ErrorCode::OutOfRange, reader.at(reader.member("fps") ? "fps" : "frames"),
                   "puts frame " + std::to_string(moments.frames - 1) + " at " +
                       number_text(moments.at(moments.frames - 1)) + " s, which is after " + number_text(kMostSeconds) +
                       " s");
    return moments;
}

/// The body without what is a sequence's own, as one of its jobs.
json job_of(const json& body, bool along_a_path, BodyFaults& faults) {
    json job = body;
    for (const char* own : kOwn) job.erase(own);
    for (const char* member : {"time", "first_pass"})
        if (job.contains(member)) {
            faults.add(ErrorCode::UnknownField, std::string("/") + member,
                       std::string("is a job's: frames have a time of their own, and all their passes"));
            job.erase(member);
        }
    if (!along_a_path && (!job.contains("animation") || job["animation"].is_null())) job["animation"] = 0;
    return job;
}

}  // namespace

SequenceRequest parse_sequence_request(const json& body, const JobVocabulary& vocabulary) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    if (!body.is_object()) faults.throw_if_any();
    const Moments moments = read_moments(reader);
    const std::string noise = reader.word("noise", {"fresh", "still"}).value_or("fresh");
    std::optional<CameraPath> path;
    const json* given_path = reader.member("camera_path");
    if (given_path) path = read_camera_path(*given_path, reader.at("camera_path"), faults);
    JobRequest first;
    try {
        first = parse_job_request(job_of(body, given_path != nullptr, faults), vocabulary);
    } catch (const Error& error) {
        faults.take(error.code, std::vector<Fault>(error.faults));
    }
    if (faults.size() == 0 && path && path->turns && !first.camera.look_at)
        faults.add(ErrorCode::MissingField, "/camera/look_at", "is required: turns begin there");
    faults.throw_if_any();

    SequenceRequest sequence;
    const LookAt start = first.camera.look_at.value_or(LookAt());
    for (uint32_t i = 0; i < moments.frames; ++i) {
        JobRequest frame = first;
        if (first.animation) frame.time = moments.at(i);
        if (noise == "fresh") frame.seed = first.seed + i;
        if (path) {
            frame.camera.name.clear();
            frame.camera.look_at = view_along(*path, start, moments.at(i), i / static_cast<double>(moments.frames));
            if (const std::string fault = fault_of_view(*frame.camera.look_at); !fault.empty())
                throw Error(ErrorCode::Conflict, path->turns ? "/camera_path/turns" : "/camera_path/keys",
                            "gives frame " + std::to_string(i) + ", at " + number_text(moments.at(i)) +
                                " s, no view: " + fault);
        }
        sequence.frames.push_back(std::move(frame));
    }
    sequence.echo = to_json(first);
    for (const char* member : {"time", "first_pass"}) sequence.echo.erase(member);
    sequence.echo.update({{"from", moments.from},
                          {"to", nullptr},
                          {"fps", moments.fps},
                          {"frames", moments.frames},
                          {"noise", noise},
                          {"camera_path", path ? to_json(*path) : json(nullptr)}});
    return sequence;
}

}  // namespace photond
