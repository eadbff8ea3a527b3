#include "server/store/quarantine.h"

#include <cerrno>
#include <cstring>
#include <ctime>

#include "protocol/error.h"
#include "server/store/data_files.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFolder = "quarantine";

uint64_t files_below(const fs::path& path) {
    std::error_code error;
    if (!fs::is_directory(fs::symlink_status(path, error))) return 1;
    uint64_t files = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path, error))
        files += !entry.is_directory();
    return files;
}

std::string today() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    char text[16];
    return {text, std::strftime(text, sizeof text, "%Y-%m-%d", &utc)};
}

}  // namespace

Quarantine::Quarantine(const fs::path& data_folder) : data_folder_(data_folder) {
    if (!fs::exists(data_folder_ / kFolder)) return;
    files_ = files_below(data_folder_ / kFolder);
    bytes_ = bytes_below(data_folder_ / kFolder);
}

fs::path Quarantine::take(const fs::path& path, const std::string& reason) {
    const fs::path folder = fs::path(kFolder) / (today() + "-" + reason) / path.parent_path();
    std::error_code error;
    fs::create_directories(data_folder_ / folder, error);
    if (error)
        throw Error(error == std::errc::no_space_on_device ? ErrorCode::NoSpace : ErrorCode::Internal,
                    "making " + folder.string() + ": " + error.message());
    fs::path to = folder / path.filename();
    for (int again = 2; fs::exists(fs::symlink_status(data_folder_ / to)); ++again)  // of that name, the same day
        to = folder / (path.filename().string() + "." + std::to_string(again));
    const uint64_t files = files_below(data_folder_ / path), bytes = bytes_below(data_folder_ / path);
    publish(data_folder_ / path, data_folder_ / to);
    files_ += files;
    bytes_ += bytes;
    return to;
}

}  // namespace photond
