#pragma once
// Encoded artefacts (EXR, PNG, raw pixels): pure functions of a film, so they are kept as long as there is room and
// made again when they are gone.

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace photond {

struct CachedFile {
    std::filesystem::path path;
    std::string etag;  // SHA-256 of the contents
    uint64_t bytes = 0;
    std::map<std::string, std::string> headers;

    CachedFile() = default;
    CachedFile(const CachedFile&) = delete;
    CachedFile& operator=(const CachedFile&) = delete;
    /// The file goes with its last user.
    ~CachedFile();
};

/// Thread-safe.
class ArtefactCache {
public:
    explicit ArtefactCache(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}

    /// Writes a file at `path` and returns what the bytes alone do not say.
    using Make = std::function<std::map<std::string, std::string>(const std::filesystem::path& path)>;
    /// The file under `key`; made by this caller when it is not there, while others who ask for the same key wait.
    std::shared_ptr<const CachedFile> get(const std::string& key, const std::filesystem::path& fresh_path,
                                          const Make& make);
    /// The same where it is there now; else null.
    std::shared_ptr<const CachedFile> find(const std::string& key);
    /// Forgets all whose key starts with `prefix`.
    void forget(const std::string& prefix);

private:
    /// Under the lock: null where it is not there; else it is the last to go.
    std::shared_ptr<const CachedFile> used(const std::string& key);
    void insert(const std::string& key, std::shared_ptr<const CachedFile> file);

    struct Entry {
        std::shared_ptr<const CachedFile> file;
        std::list<std::string>::iterator place;
    };
    const uint64_t limit_bytes_;
    std::mutex mutex_;
    std::condition_variable made_;
    std::map<std::string, Entry> entries_;
    std::list<std::string> order_;  // least recently used first
    std::set<std::string> being_made_;
    uint64_t bytes_ = 0;
};

}  // namespace photond
