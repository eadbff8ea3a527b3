#pragma once
// Large files of formats whose readers find out by themselves what is not whole: as an AtomicFile (atomic_file.h), but
// for less of the time.

#include <cstdlib>
#include <filesystem>
#include <memory>

namespace photond {

/// A file under construction as AtomicFile::part_of(PATH), visible under its own name after commit(). Without commit()
/// nothing stays. It goes to the disk past the system's cache of pages, where the file system can do that. What has no
/// predecessor of its name is named before it is synced, which is one writing of the file system's journal in place of
/// two: after a power cut meanwhile a file that is not whole may have the name. Throws as an AtomicFile does.
class CheckedFile {
public:
    explicit CheckedFile(const std::filesystem::path& path);
    ~CheckedFile();
    CheckedFile(const CheckedFile&) = delete;
    CheckedFile& operator=(const CheckedFile&) = delete;

    void write(const void* data, size_t bytes);
    void commit();

private:
    struct Free {
        void operator()(char* memory) const { std::free(memory); }
    };

    /// The first bytes of the buffer, which it then no longer holds.
    void write_out(size_t bytes);
    /// From here on by way of the system's cache.
    void leave_direct();

    std::filesystem::path path_;
    std::filesystem::path part_;
    int file_ = -1;
    std::unique_ptr<char, Free> buffer_;  // at an address that a disk can read from
    size_t held_ = 0;                     // bytes of it
};

}  // namespace photond
