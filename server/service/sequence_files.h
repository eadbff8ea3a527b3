#pragma once
// All frames of a sequence as one file.

#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "server/service/artefact_files.h"
#include "server/service/jobs.h"
#include "server/service/sequences.h"
#include "server/service/service_types.h"

namespace photond {

/// Of the frames that have succeeded so far; pending while there is none. All wait for the helper, throw NotFound, and
/// what images throw.
class SequenceFiles {
public:
    SequenceFiles(ArtefactFiles& artefact_files, ServiceCore& core, Jobs& jobs, Sequences& sequences)
        : artefact_files_(artefact_files), core_(core), jobs_(jobs), sequences_(sequences) {}

    /// A ZIP of 0000.exr, 0001.exr ... or 0000.png ... by `images`. Throws OutOfRange for another word.
    Artefact frames_zip(const std::string& id, const std::string& images);
    /// An MP4 by the system's ffmpeg, or a PNG: at most 100 frames, evenly chosen, beside each other. Throws OutOfRange
    /// for what `wanted` may not say, Unsupported at /format for an MP4 where there is no ffmpeg or it fails, TimedOut,
    /// TryLater while another video is encoded, Unavailable while the daemon ends.
    Artefact video(const std::string& id, const VideoWanted& wanted);

private:
    struct FrameImage {
        int frame = 0;
        Artefact image;  // which stays readable as long as this does
    };
    /// In order, without those whose image is pending.
    static std::vector<FrameImage> frame_images(const nlohmann::json& sequence,
                                                const std::function<Artefact(const std::string& job)>& image_of);
    Artefact mp4(const nlohmann::json& sequence, const std::filesystem::path& ffmpeg, double fps,
                 const PreviewWanted& look);
    Artefact sheet(const nlohmann::json& sequence, const PreviewWanted& look);

    ArtefactFiles& artefact_files_;
    ServiceCore& core_;
    Jobs& jobs_;
    Sequences& sequences_;
    std::mutex encoding_;  // one video at a time
};

}  // namespace photond
