#include "server/service/sequence_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "protocol/helper_messages.h"
#include "server/try_later.h"
#include "server/workers/video_process.h"

namespace photond {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr double kLeastFps = 1, kGreatestFps = 120;
constexpr size_t kMostOfSheet = 100;    // frames
constexpr uint32_t kSheetColumns = 10;  // ... beside each other
constexpr uint32_t kSheetSide = 256;    // of a frame's longer side
constexpr int kOtherVideoSeconds = 2;   // after which to ask again

using Headers = std::map<std::string, std::string>;

std::vector<json> succeeded_frames(const json& sequence) {
    std::vector<json> frames;
    for (const json& frame : sequence.at("frames"))
        if (frame.at("state") == "succeeded") frames.push_back(frame);
    return frames;
}

/// At most so many, the first and the last among them.
std::vector<json> evenly_chosen(const std::vector<json>& frames, size_t most) {
    if (frames.size() <= most) return frames;
    std::vector<json> chosen;
    for (size_t i = 0; i < most; ++i) chosen.push_back(frames[i * (frames.size() - 1) / (most - 1)]);
    return chosen;
}

/// What a packer leaves that was ended: libzip writes beside the file first.
void remove_unfinished(const fs::path& path) {
    const std::string beginning = path.filename().string() + ".";
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(path.parent_path(), error))
        if (entry.path().filename().string().starts_with(beginning)) fs::remove(entry.path(), error);
}

void check_fps(const std::optional<double>& fps) {
    if (fps && !(*fps >= kLeastFps && *fps <= kGreatestFps))
        throw Error(ErrorCode::OutOfRange, "/fps", "fps = " + json(*fps).dump() + " is outside [1, 120] a second");
}

}  // namespace

std::vector<SequenceFiles::FrameImage> SequenceFiles::frame_images(
    const json& sequence, const std::function<Artefact(const std::string& job)>& image_of) {
    std::vector<FrameImage> images;
    for (const json& frame : succeeded_frames(sequence)) {
        Artefact image = image_of(frame.at("id").get<std::string>());
        if (!image.pending) images.push_back({frame.at("frame").get<int>(), std::move(image)});
    }
    return images;
}

Artefact SequenceFiles::frames_zip(const std::string& id, const std::string& images) {
    if (images != "exr" && images != "png")
        throw Error(ErrorCode::OutOfRange, "/images", "images = '" + images + "' is neither exr nor png");
    const json sequence = sequences_.get_sequence(id);
    const std::vector<FrameImage> frames = frame_images(sequence, [&](const std::string& job) {
        return images == "exr" ? jobs_.artefacts.image(job, "float") : jobs_.artefacts.preview(job, PreviewWanted());
    });
    if (frames.empty()) return pending_artefact();
    PackRequest pack;
    std::string content;
    uint64_t bytes = 0;
    for (const FrameImage& frame : frames) {
        char name[32];
        std::snprintf(name, sizeof name, "%04d.%s", frame.frame, images.c_str());
        pack.items.push_back({frame.image.path, name});
        content += name + (" " + frame.image.etag) + "\n";
        bytes += frame.image.bytes;
    }
    return artefact_files_.artefact(sequence_key(sequence, images, content), "application/zip",
                                    [&](const fs::path& path) {
                                        core_.check_disk(bytes);
                                        pack.out = path;
                                        try {
                                            core_.bulk_helper->ask(pack);
                                        } catch (...) {
                                            remove_unfinished(path);
                                            throw;
                                        }
                                        return Headers();
                                    });
}

Artefact SequenceFiles::video(const std::string& id, const VideoWanted& wanted) {
    const bool any = wanted.format == "auto";
    if (!any && wanted.format != "mp4" && wanted.format != "png")
        throw Error(ErrorCode::OutOfRange, "/format", "format = '" + wanted.format + "' is none of auto, mp4, png");
    check_fps(wanted.fps);
    const PreviewWanted look{.exposure_stops = wanted.exposure_stops, .curve = wanted.curve};
    JobArtefacts::check_look(look);
    const json sequence = sequences_.get_sequence(id);
    if (wanted.format == "png") return sheet(sequence, look);
    const std::optional<fs::path> ffmpeg = system_ffmpeg();
    if (!ffmpeg && any) return sheet(sequence, look);
    if (!ffmpeg)
        throw Error(ErrorCode::Unsupported, "/format",
                    "there is no ffmpeg on the daemon's PATH; format=png needs none");
    const auto own = sequence.at("request").at("fps").get<double>();
    return mp4(sequence, *ffmpeg, wanted.fps.value_or(std::clamp(own, kLeastFps, kGreatestFps)), look);
}

Artefact SequenceFiles::mp4(const json& sequence, const fs::path& ffmpeg, double fps, const PreviewWanted& look) {
    const std::vector<FrameImage> frames =
        frame_images(sequence, [&](const std::string& job) { return jobs_.artefacts.preview(job, look); });
    if (frames.empty()) return pending_artefact();
    EncodeVideoMessage order;
    order.fps = fps;
    std::string content = json(fps).dump() + "\n";
    for (const FrameImage& frame : frames) {
        order.pictures.push_back(frame.image.path);
        content += frame.image.etag + "\n";
    }
    return artefact_files_.artefact(sequence_key(sequence, "mp4", content), "video/mp4", [&](const fs::path& path) {
        const std::unique_lock alone(encoding_, std::try_to_lock);
        if (!alone) throw TryLater("another video is being encoded", kOtherVideoSeconds);
        ProcessOptions process = core_.process_options();
        process.reads = {core_.files.cache};
        process.writes = {core_.files.cache};
        // Beside a job it takes one core that nobody else wants; else all.
        process.threads = core_.jobs_on_host_cores > 0 ? 1 : core_.options.threads;
        order.out = path;
        encode_video(std::move(process), ffmpeg, order,
                     core_.options.limits.helper_timeout_seconds * kBackgroundPatience, [this] {
                         const std::lock_guard lock(core_.mutex);
                         return core_.stopping;
                     });
        return Headers();
    });
}

Artefact SequenceFiles::sheet(const json& sequence, const PreviewWanted& look) {
    std::vector<FilmSource> films;  // held until they are read
    EncodeSheetRequest request;
    std::string content = json(look.exposure_stops).dump() + " " + look.curve + "\n";
    for (const json& frame : evenly_chosen(succeeded_frames(sequence), kMostOfSheet)) {
        FilmSource film = jobs_.films.film_source(frame.at("id").get<std::string>());
        if (film.pending) continue;
        jobs_.films.pin(film);
        request.films.push_back(film.path);
        content += film.cache_key + "\n";
        films.push_back(std::move(film));
    }
    if (films.empty()) return pending_artefact();
    request.columns = kSheetColumns;
    request.max_size = kSheetSide;
    request.exposure = look.exposure_stops;
    request.curve = look.curve;
    return artefact_files_.artefact(sequence_key(sequence, "sheet", content), "image/png", [&](const fs::path& path) {
        request.out = path;
        core_.helper->ask(request);
        return Headers();
    });
}

}  // namespace photond
