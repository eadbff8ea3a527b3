#pragma once
// What was uploaded and is not in its place yet.

#include <filesystem>
#include <string>
#include <utility>

#include "protocol/error.h"
#include "server/store/data_files.h"

namespace photond {

inline constexpr size_t kContentIdDigits = 32;  // of scenes and images: 128 bits of a SHA-256

/// Within the data folder.
inline std::string path_of_scene(const std::string& id) { return "scenes/" + id; }
inline std::string path_of_image(const std::string& file) { return "images/" + file; }

/// Removes what was spooled, whatever becomes of it.
struct Spooled {
    std::filesystem::path path;

    explicit Spooled(std::filesystem::path spooled) : path(std::move(spooled)) {}
    Spooled(const Spooled&) = delete;
    Spooled& operator=(const Spooled&) = delete;
    ~Spooled() {
        if (!path.empty()) remove_quietly(path);
    }
};

/// What `ask` hears of the helper; throws `code` where the helper could not get through the upload, which is to blame.
template <class Ask>
auto judged(ErrorCode code, const Ask& ask) {
    try {
        return ask();
    } catch (const Error& error) {
        switch (error.code) {
            case ErrorCode::WorkerCrashed:
            case ErrorCode::OutOfMemory:
            case ErrorCode::TimedOut: throw Error(code, "", std::string("cannot be read: ") + error.what());
            default: throw;
        }
    }
}

}  // namespace photond
