#include "server/store/data_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>

#include "protocol/error.h"
#include "renderer/core/atomic_file.h"
#include "renderer/core/sha256.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const std::string& doing, const fs::path& path, int error) {
    const bool full = error == ENOSPC || error == EDQUOT;
    throw Error(full ? ErrorCode::NoSpace : ErrorCode::Internal,
                doing + " " + path.string() + ": " + std::strerror(error));
}

struct CloseFile {
    void operator()(FILE* file) const { std::fclose(file); }
};

/// Feeds a file's bytes to the digest; returns how many.
uint64_t hash_contents(const fs::path& path, Sha256& digest) {
    const std::unique_ptr<FILE, CloseFile> file(std::fopen(path.c_str(), "rbe"));
    if (!file) fail("opening", path, errno);
    static constexpr size_t kChunk = size_t{1} << 18;
    const auto chunk = std::make_unique<char[]>(kChunk);
    uint64_t bytes = 0;
    while (const size_t read = std::fread(chunk.get(), 1, kChunk, file.get())) {
        digest.update(chunk.get(), read);
        bytes += read;
    }
    if (std::ferror(file.get())) fail("reading", path, EIO);
    return bytes;
}

constexpr const char* kMark = "store-id";

/// What lies in it is nobody else's to read. One of another owner stays as that has set it.
void for_this_user_alone(const fs::path& path, mode_t mode) {
    struct stat status {};
    if (lstat(path.c_str(), &status) != 0 || S_ISLNK(status.st_mode) || (status.st_mode & 0777) == mode) return;
    if (chmod(path.c_str(), mode) != 0 && errno != EPERM && errno != EROFS) fail("setting the mode of", path, errno);
}

void make(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) fail("making", folder, error.value());
}

/// 0, or what went wrong. A process that a photond was about to start when it was killed holds its lock until it runs
/// its own program: it is waited for.
int take_lock(int file) {
    constexpr int kTries = 100;
    constexpr std::chrono::milliseconds kBetween{10};
    for (int i = 0; flock(file, LOCK_EX | LOCK_NB) != 0; ++i) {
        if (errno == EINTR) continue;
        if (errno != EWOULDBLOCK || i == kTries) return errno;
        std::this_thread::sleep_for(kBetween);
    }
    return 0;
}

}  // namespace

DataFiles::DataFiles(const fs::path& folder, Use use)
    : directory(folder),
      store(directory / "store.sqlite"),
      scenes(directory / "scenes"),
      images(directory / "images"),
      films(directory / "films"),
      cache(directory / "cache"),
      spool(directory / "spool"),
      pipeline_cache(directory / "pipeline-cache") {
    const std::array folders{directory, scenes, images, films, cache, spool, pipeline_cache};
    if (use == Use::Serve)
        for (const fs::path& one : folders) make(one);
    const fs::path lock_file = directory / "photond.lock";
    lock_ = open(lock_file.c_str(), (use == Use::Serve ? O_RDWR | O_CREAT : O_RDONLY) | O_CLOEXEC, 0600);
    if (lock_ < 0 && !(use == Use::Read && errno == ENOENT)) fail("opening", lock_file, errno);
    if (const int error = lock_ >= 0 ? take_lock(lock_) : 0) {
        close(lock_);
        if (error == EWOULDBLOCK)
            throw Error(ErrorCode::Unavailable, "another photond uses the data directory " + directory.string());
        fail("locking", lock_file, error);
    }
    if (use == Use::Read) return;
    for (const fs::path& one : folders) for_this_user_alone(one, 0700);
    for (const char* end : {"", "-wal"}) for_this_user_alone(store.string() + end, 0600);
    sync_path(directory);
}

DataFiles::~DataFiles() {
    if (lock_ >= 0) close(lock_);
}

uint64_t DataFiles::free_bytes() const {
    struct statvfs status {};
    if (statvfs(directory.c_str(), &status) != 0) fail("asking for the free space of", directory, errno);
    return static_cast<uint64_t>(status.f_bavail) * status.f_frsize;
}

std::string DataFiles::marked_store() const {
    std::ifstream file(directory / kMark);
    std::string marked;
    file >> marked;
    return marked;
}

bool DataFiles::are_of(const std::string& store_id) const {
    const std::string marked = marked_store();
    return marked.empty() || marked == store_id;
}

void DataFiles::become_of(const std::string& store_id) {
    if (marked_store() == store_id) return;
    AtomicFile file(directory / kMark);
    file.write(store_id.data(), store_id.size());
    file.write("\n", 1);
    file.commit();
}

std::vector<fs::path> list_tree(const fs::path& root, size_t max_files) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
        const fs::file_status status = entry.symlink_status();
        if (fs::is_directory(status)) continue;
        const fs::path relative = entry.path().lexically_relative(root);
        if (!fs::is_regular_file(status))
            throw Error(ErrorCode::BadScene, "", relative.string() + " is neither a regular file nor a folder");
        files.push_back(relative);
        if (files.size() > max_files)
            throw Error(ErrorCode::BadScene, "", "more than " + std::to_string(max_files) + " files in the bundle");
    }
    std::sort(files.begin(), files.end());
    return files;
}

std::string hash_tree(const fs::path& root, const std::vector<fs::path>& files) {
    Sha256 digest;
    for (const fs::path& file : files) {
        // The contents go in as a digest of their own, so that no file's bytes can pass for another's path.
        const std::string line = file.generic_string() + '\0' + hash_file(root / file) + '\n';
        digest.update(line.data(), line.size());
    }
    return digest.hex_digest();
}

std::string hash_file(const fs::path& file) {
    Sha256 digest;
    hash_contents(file, digest);
    return digest.hex_digest();
}

void sync_path(const fs::path& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) fail("opening", path, errno);
    const int result = fsync(file);
    const int error = errno;
    close(file);
    if (result != 0) fail("syncing", path, error);
}

void sync_tree(const fs::path& root, const std::vector<fs::path>& files) {
    for (const fs::path& file : files) sync_path(root / file);
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root))
        if (entry.is_directory()) sync_path(entry.path());
    sync_path(root);
}

void publish(const fs::path& from, const fs::path& to) {
    if (std::rename(from.c_str(), to.c_str()) != 0) fail("renaming to", to, errno);
    sync_path(to.parent_path());
}

uint64_t bytes_below(const fs::path& path) noexcept {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(path, error);
    if (fs::is_regular_file(status)) {
        const uintmax_t bytes = fs::file_size(path, error);
        return error ? 0 : bytes;
    }
    uint64_t sum = 0;
    if (fs::is_directory(status))
        for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) sum += bytes_below(entry.path());
    return sum;
}

void remove_quietly(const fs::path& path) noexcept {
    std::error_code ignored;
    fs::remove_all(path, ignored);
}

}  // namespace photond
