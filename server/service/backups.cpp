#include "server/service/backups.h"

#include <set>
#include <thread>
#include <unordered_set>
#include <utility>

#include "server/clock_text.h"
#include "server/service/artefact_files.h"
#include "server/service/saved_film.h"
#include "server/service/uploads.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kStoreName = "store.sqlite";
constexpr int kPagesAtOnce = 256;  // a megabyte, while others wait for the store
constexpr size_t kFilesAtOnce = 64;

}  // namespace

struct Backups::Backup {
    std::string id;
    int64_t created_ms = 0;
    fs::path folder;
    std::map<std::string, uint64_t> files;    // by path within a data folder: bytes
    std::unordered_set<std::string> settled;  // named once, and nobody writes to them any more

    ~Backup() { remove_quietly(folder); }
    uint64_t bytes() const {
        uint64_t sum = 0;
        for (const auto& [path, size] : files) sum += size;
        return sum;
    }
    json object(const std::string& store_id) const {
        json listed = json::array();
        for (const auto& [path, size] : files) listed.push_back({{"path", path}, {"bytes", size}});
        return {{"id", id},
                {"created", rfc3339(created_ms)},
                {"store", store_id},
                {"bytes", bytes()},
                {"files", std::move(listed)}};
    }
};

void Backups::add_files(Backup& backup, bool last, std::unique_lock<std::mutex>& lock) {
    std::set<std::string> now;
    size_t added = 0;
    const auto add = [&](const std::string& path, bool settled) {
        now.insert(path);
        if (backup.settled.contains(path)) return;
        const fs::path from = core_.files.directory / path, to = backup.folder / path;
        fs::create_directories(to.parent_path());
        remove_quietly(to);
        try {
            link_or_copy(from, to);
        } catch (const Error& error) {
            if (error.code == ErrorCode::NotFound) return;  // removed meanwhile, or gone: the row is kept as it is
            throw;
        }
        backup.files[path] = fs::file_size(to);
        if (settled) backup.settled.insert(path);
        if (last || ++added % kFilesAtOnce != 0) return;
        lock.unlock();
        std::this_thread::yield();
        lock.lock();
    };
    std::unordered_set<std::string> unsettled;
    for (const JobRow& row : core_.store.running_jobs()) unsettled.insert(row.film);
    for (const FilmRow& row : core_.store.films())
        for (const std::string& path : files_of_film(row)) add(path, !unsettled.contains(row.film));
    for (const std::string& id : core_.store.scene_ids()) {
        const fs::path root = core_.files.scenes / id;
        if (backup.settled.contains(path_of_scene(id)) || !fs::is_directory(root)) {
            for (const auto& [path, size] : backup.files)
                if (path.starts_with(path_of_scene(id) + "/")) now.insert(path);
            continue;
        }
        for (const fs::path& file : list_tree(root, kMostFilesOfScene))
            add(path_of_scene(id) + "/" + file.generic_string(), true);
        backup.settled.insert(path_of_scene(id));
    }
    for (const auto& [id, file] : core_.store.image_files()) add(path_of_image(file), true);
    if (last) std::erase_if(backup.files, [&](const auto& file) { return !now.contains(file.first); });
}

json Backups::make() {
    const std::lock_guard making(making_);
    core_.check_disk(bytes_below(core_.files.store));
    auto backup = std::make_shared<Backup>();
    backup->created_ms = now_ms();
    backup->id = "B" + std::to_string(backup->created_ms);
    backup->folder = core_.files.fresh_spool_path();
    fs::create_directory(backup->folder);
    {
        const std::lock_guard lock(mutex_);
        newest_.reset();  // room for this one
    }
    const fs::path copied = backup->folder / kStoreName;
    {
        std::unique_lock lock(core_.mutex);
        Database::Copy copy(core_.store.database(), copied);  // ends under the lock too
        add_files(*backup, false, lock);
        while (copy.step(kPagesAtOnce) > kPagesAtOnce) {
            lock.unlock();
            std::this_thread::yield();
            lock.lock();
        }
        // The rest in one go: rows and files of one moment.
        copy.step(-1);
        add_files(*backup, true, lock);
    }
    backup->files[kStoreName] = fs::file_size(copied);
    const std::lock_guard lock(mutex_);
    newest_ = backup;
    return backup->object(core_.store.id());
}

std::shared_ptr<const Backups::Backup> Backups::require(const std::string& id) {
    const std::lock_guard lock(mutex_);
    if (!newest_ || newest_->id != id)
        throw Error(ErrorCode::NotFound, "there is no backup '" + id +
                                             "': it was removed, a later one took its place, "
                                             "or the daemon was started again");
    return newest_;
}

json Backups::get(const std::string& id) { return require(id)->object(core_.store.id()); }

Artefact Backups::file(const std::string& id, const std::string& path) {
    const auto backup = require(id);
    const auto found = backup->files.find(path);
    if (found == backup->files.end()) throw Error(ErrorCode::NotFound, "backup " + id + " has no file '" + path + "'");
    Artefact file;
    file.path = backup->folder / path;
    file.media_type = "application/octet-stream";
    file.etag = id + "-" + std::to_string(std::distance(backup->files.begin(), found));
    file.bytes = found->second;
    file.pin = backup;
    return file;
}

json Backups::remove(const std::string& id) {
    json object = get(id);
    const std::lock_guard lock(mutex_);
    newest_.reset();
    return object;
}

}  // namespace photond
