#pragma once
// Scenes and images named by path become scenes and images of the daemon.

#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/session.h"

namespace photond::cli {

struct UploadedScene {
    nlohmann::json scene;
    bool known_before = false;  // ids are made from the content: the daemon had it already
};

/// Sends what lies at `path`; `name` empty: the file's. Its warnings are remarked.
UploadedScene upload_scene(Session& session, const std::string& path, const std::string& name);

/// Sends a .exr or .hdr; the image's id.
std::string upload_image(Session& session, const std::string& path);

}  // namespace photond::cli
