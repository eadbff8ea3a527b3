#pragma once
// The data directory: its folders, and the file operations that make a result durable before a row names it.
//
//   photond.lock   held by the one daemon that uses the directory
//   store.sqlite   the truth; a file that no row names is an orphan
//   scenes/ID/     uploaded scenes as unpacked     images/ID   uploaded images
//   films/         films of jobs, one an attempt   cache/      encoded artefacts, emptied at start
//   spool/         uploads under way, emptied at start
//   pipeline-cache/  a file for each GPU, and what Mesa's and NVIDIA's drivers keep: what was compiled, for the next
//   worker quarantine/    what a start found and could not tell (quarantine.h); never emptied store-id       the store
//   whose files lie here

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace photond {

class DataFiles {
public:
    enum class Use : uint8_t { Serve, Read };

    /// Makes the folders, for this user alone, and takes the lock; or takes the lock alone, to read. Throws
    /// photond::Error when another daemon has the lock or the directory cannot be used.
    explicit DataFiles(const std::filesystem::path& directory, Use use = Use::Serve);
    ~DataFiles();
    DataFiles(const DataFiles&) = delete;
    DataFiles& operator=(const DataFiles&) = delete;

    const std::filesystem::path directory, store, scenes, images, films, cache, spool, pipeline_cache;

    /// A name nobody else was given.
    std::filesystem::path fresh_spool_path() { return spool / ("u" + std::to_string(++counter_)); }
    std::filesystem::path fresh_cache_path() { return cache / ("a" + std::to_string(++counter_)); }

    uint64_t free_bytes() const;

    /// Whether what lies in the folders is of that store: its id is written down here, or none is, as in folders of
    /// older versions.
    bool are_of(const std::string& store_id) const;
    /// From here on they are.
    void become_of(const std::string& store_id);

private:
    std::string marked_store() const;

    std::atomic<uint64_t> counter_ = 0;
    int lock_ = -1;
};

/// Of a scene that is kept: it was judged when it was uploaded.
inline constexpr size_t kMostFilesOfScene = 1'000'000;

/// The regular files below a folder, as sorted relative paths. Throws BadScene for anything that is neither a regular
/// file nor a folder (a link, a FIFO), and for more than `max_files`.
std::vector<std::filesystem::path> list_tree(const std::filesystem::path& root, size_t max_files);
/// SHA-256 over the relative paths and contents of those files, in their order; 64 hexadecimal digits.
std::string hash_tree(const std::filesystem::path& root, const std::vector<std::filesystem::path>& files);
std::string hash_file(const std::filesystem::path& file);

/// fsync of a file or a folder. Throws NoSpace or Internal.
void sync_path(const std::filesystem::path& path);
/// fsync of every file and folder below `root`, and of itself.
void sync_tree(const std::filesystem::path& root, const std::vector<std::filesystem::path>& files);
/// Renames, both folders' entries being on the disk when it returns.
void publish(const std::filesystem::path& from, const std::filesystem::path& to);
/// The bytes of a file, or of all files below a folder; 0 where there is none.
uint64_t bytes_below(const std::filesystem::path& path) noexcept;
/// Removes a file or a tree; what is not there is no failure.
void remove_quietly(const std::filesystem::path& path) noexcept;

}  // namespace photond
