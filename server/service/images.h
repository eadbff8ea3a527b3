#pragma once
// Uploaded images: references and environments. Judged by the helper, moved into place, and only then named by a row.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/service/artefact_files.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

/// All take the lock where they need it, and wait for the helper without it. Those that are given an id throw NotFound.
class Images {
public:
    Images(ServiceCore& core, ArtefactFiles& artefact_files) : core_(core), artefact_files_(artefact_files) {}

    /// Throws WrongMediaType, BadImage.
    Added add_image(const std::filesystem::path& spooled, const std::string& media_type);
    nlohmann::json get_image(const std::string& id);
    /// The file as uploaded.
    Artefact image_file(const std::string& id);
    /// One of its layers. Throws UnknownName at /layer where it has none of that name.
    Artefact image_pixels(const std::string& id, const std::string& layer, const std::string& precision);

private:
    /// What was uploaded before layers were noted is looked at again, by the helper.
    std::optional<ImageRow> find_image(const std::string& id);
    ImageRow require_image(const std::string& id);

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
};

}  // namespace photond
