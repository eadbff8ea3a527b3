#pragma once
// Where a start puts what it cannot tell: quarantine/DATE-REASON/FOLDER/NAME in the data folder. Nothing there is ever
// removed by the service.

#include <cstdint>
#include <filesystem>
#include <string>

namespace photond {

class Quarantine {
public:
    /// Looks at what is there already.
    explicit Quarantine(const std::filesystem::path& data_folder);

    /// Moves a file or a folder, given by its path within the data folder. `reason`: a word or two, "no-row". Returns
    /// where it is now, likewise. Throws NoSpace or Internal; it is then where it was.
    std::filesystem::path take(const std::filesystem::path& path, const std::string& reason);
    uint64_t files() const { return files_; }
    uint64_t bytes() const { return bytes_; }

private:
    const std::filesystem::path data_folder_;
    uint64_t files_ = 0, bytes_ = 0;  // regular files, at any depth
};

}  // namespace photond
