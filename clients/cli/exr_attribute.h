#pragma once
// What the header of an OpenEXR file says beside the image.

#include <filesystem>
#include <optional>
#include <string>

namespace photond::cli {

/// The text attribute of that name in the header of the file's first part; none where it has none. Throws
/// Failure(Usage) for what cannot be read or is no OpenEXR file.
std::optional<std::string> exr_text_attribute(const std::filesystem::path& file, const std::string& name);

}  // namespace photond::cli
