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
    /// The same by one writing of the file system's journal in place of two, where nothing has that name yet: the file
    /// is named before it is synced. After a power cut meanwhile one that is not whole may have the name, so this is
    /// for formats whose readers find that out.
    void commit_checked();

private:
    void flush();
    /// Renamed from PATH.part: the folder is synced too.
    void sync_folder() const;
    [[noreturn]] void fail(const char* what, int error) const;

    std::filesystem::path path_;
    std::filesystem::path part_;
    FILE* file_ = nullptr;
};

}  // namespace photond
