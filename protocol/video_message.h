#pragma once
// What the daemon tells photond-worker --device video, once. That process then becomes the system's ffmpeg, in the
// sandbox, and says no more than how it ends.

#include <filesystem>
#include <vector>

#include "protocol/message_json.h"

namespace photond {

struct EncodeVideoMessage {
    static constexpr const char* kType = "encode_video";
    std::vector<std::filesystem::path> pictures;  // PNG, of one size, in order
    double fps = 24;                              // pictures a second
    std::filesystem::path out;                    // MP4

    void visit(MessageVisitor& visitor) {
        visitor.member("pictures", pictures);
        visitor.member("fps", fps);
        visitor.member("out", out);
    }
};

}  // namespace photond
