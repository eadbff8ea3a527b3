#pragma once
// Files that appear whole or not at all: written beside, fsynced, renamed, and the folder fsynced.

#include <cstdio>
#include <filesystem>

namespace photond {

/// A file under construction as PATH.part, visible under its own name after commit(). Without commit() nothing stays.
/// Throws ErrorCode::NoSpace when the disk or a quota is full, ErrorCode::Internal on any other failure.
class AtomicFile {
public:
    explicit AtomicFile(const std::filesystem::path& path);
    /// What lies beside a file while it is written; of a process that was killed meanwhile it stays.
    static std::filesystem::path part_of(const std::filesystem::path& path) { return path.string() + ".part"; }
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(const void* data, size_t bytes);
    /// For libraries that write to a stream; commit() checks what they did.
    FILE* stream() { return file_; }
    void commit();

private:
    std::filesystem::path path_;
    std::filesystem::path part_;
    FILE* file_ = nullptr;
};

/// The error of a file that cannot be written: ErrorCode::NoSpace when a disk, a quota or a limit is full, else
/// ErrorCode::Internal. `what` was tried.
[[noreturn]] void fail_writing(const std::filesystem::path& path, const char* what, int error);
/// Has the disk know by which names the folder of a file holds its files. Throws likewise.
void sync_folder_of(const std::filesystem::path& path);

}  // namespace photond
