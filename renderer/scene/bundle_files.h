#pragma once
// The files a scene may read: regular files below one folder, reached without links, and the bytes inside data URIs.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace photond {

/// A folder that files are read from and never left: no absolute paths, no "..", no links, no devices or pipes, no
/// network. Each part of a path is opened in the one before, so that a file swapped during the load changes nothing.
class BundleFiles {
public:
    /// Throws ErrorCode::BadScene when `root` is not a folder. At most `max_bytes` are read over all files together.
    BundleFiles(const std::filesystem::path& root, uint64_t max_bytes);
    ~BundleFiles();
    BundleFiles(const BundleFiles&) = delete;
    BundleFiles& operator=(const BundleFiles&) = delete;

    /// The contents of a file named relative to the root. Throws ErrorCode::BadScene, at `pointer`.
    std::vector<uint8_t> read(const std::string& relative_path, const std::string& pointer);

    uint64_t bytes_read() const { return bytes_read_; }

private:
    int root_ = -1;
    uint64_t bytes_left_;
    uint64_t bytes_read_ = 0;
};

/// The relative file path a glTF URI names (percent-encoding decoded). Throws ErrorCode::BadScene, at `pointer`, for a
/// URI with a scheme, an absolute path, a ".." or a control character.
std::string path_of_uri(std::string_view uri, const std::string& pointer);

bool is_data_uri(std::string_view uri);
/// The bytes of a base64 data URI. Throws ErrorCode::BadScene, at `pointer`, for any other coding or malformed base64.
std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& pointer);

}  // namespace photond
