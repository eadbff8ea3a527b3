#include "server/store/artefact_cache.h"

#include <vector>

#include "server/store/data_files.h"

namespace photond {

CachedFile::~CachedFile() {
    if (!path.empty()) remove_quietly(path);
}

std::shared_ptr<const CachedFile> ArtefactCache::get(const std::string& key, const std::filesystem::path& fresh_path,
                                                     const Make& make) {
    std::unique_lock lock(mutex_);
    made_.wait(lock, [&] { return !being_made_.contains(key); });
    if (auto file = used(key)) return file;
    being_made_.insert(key);
    lock.unlock();

    // Whoever waits for this key goes on whatever happens here, and makes it again where it failed.
    struct Done {
        ArtefactCache& cache;
        const std::string& key;
        ~Done() {
            const std::lock_guard relock(cache.mutex_);
            cache.being_made_.erase(key);
            cache.made_.notify_all();
        }
    } const done{*this, key};

    auto file = std::make_shared<CachedFile>();
    file->path = fresh_path;
    file->headers = make(fresh_path);
    file->etag = hash_file(fresh_path);
    file->bytes = std::filesystem::file_size(fresh_path);
    insert(key, file);
    return file;
}

std::shared_ptr<const CachedFile> ArtefactCache::find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    return used(key);
}

std::shared_ptr<const CachedFile> ArtefactCache::used(const std::string& key) {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    order_.splice(order_.end(), order_, found->second.place);
    return found->second.file;
}

void ArtefactCache::insert(const std::string& key, std::shared_ptr<const CachedFile> file) {
    std::vector<std::shared_ptr<const CachedFile>> evicted;  // their files are removed after the lock is let go
    const std::lock_guard lock(mutex_);
    bytes_ += file->bytes;
    order_.push_back(key);
    entries_[key] = {std::move(file), std::prev(order_.end())};
    while (bytes_ > limit_bytes_ && order_.size() > 1) {
        const auto oldest = entries_.find(order_.front());
        bytes_ -= oldest->second.file->bytes;
        evicted.push_back(std::move(oldest->second.file));
        entries_.erase(oldest);
        order_.pop_front();
    }
}

void ArtefactCache::forget(const std::string& prefix) {
    const std::lock_guard lock(mutex_);
    for (auto entry = entries_.lower_bound(prefix); entry != entries_.end() && entry->first.starts_with(prefix);) {
        bytes_ -= entry->second.file->bytes;
        order_.erase(entry->second.place);
        entry = entries_.erase(entry);
    }
}

}  // namespace photond
