#include "renderer/core/checked_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "renderer/core/atomic_file.h"

namespace photond {

namespace {

constexpr size_t kBlockBytes = 4096;  // what disks write at once, or a multiple of that
constexpr size_t kBufferBytes = 1u << 20;

}  // namespace

CheckedFile::CheckedFile(const std::filesystem::path& path)
    : path_(path),
      part_(AtomicFile::part_of(path)),
      buffer_(static_cast<char*>(std::aligned_alloc(kBlockBytes, kBufferBytes))) {
    if (!buffer_) throw std::bad_alloc();
    constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW;
    file_ = open(part_.c_str(), kFlags | O_DIRECT, 0644);
    if (file_ < 0 && errno == EINVAL) file_ = open(part_.c_str(), kFlags, 0644);
    if (file_ < 0) fail_writing(path_, "cannot create", errno);
}

CheckedFile::~CheckedFile() {
    if (file_ < 0) return;
    close(file_);
    unlink(part_.c_str());
}

void CheckedFile::write(const void* data, size_t bytes) {
    const char* from = static_cast<const char*>(data);
    while (bytes > 0) {
        const size_t more = std::min(bytes, kBufferBytes - held_);
        std::memcpy(buffer_.get() + held_, from, more);
        held_ += more, from += more, bytes -= more;
        if (held_ == kBufferBytes) write_out(kBufferBytes);
    }
}

void CheckedFile::write_out(size_t bytes) {
    for (size_t done = 0; done < bytes;) {
        const ssize_t written = ::write(file_, buffer_.get() + done, bytes - done);
        if (written < 0 && errno == EINVAL && (fcntl(file_, F_GETFL) & O_DIRECT) != 0)
            leave_direct();  // this disk has larger blocks
        else if (written < 0 && errno != EINTR)
            fail_writing(path_, "cannot write", errno);
        done += static_cast<size_t>(std::max<ssize_t>(written, 0));
    }
    held_ -= bytes;
    std::memmove(buffer_.get(), buffer_.get() + bytes, held_);
}

void CheckedFile::leave_direct() {
    if (fcntl(file_, F_SETFL, fcntl(file_, F_GETFL) & ~O_DIRECT) != 0) fail_writing(path_, "cannot write", errno);
}

void CheckedFile::commit() {
    write_out(held_ / kBlockBytes * kBlockBytes);
    leave_direct();
    write_out(held_);
    // Not every file system can refuse to replace a file.
    const bool named = renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) == 0;
    int error = fsync(file_) == 0 ? 0 : errno;
    if (close(file_) != 0 && error == 0) error = errno;
    file_ = -1;
    if (error == 0 && !named && rename(part_.c_str(), path_.c_str()) != 0) error = errno;
    if (error != 0) {
        unlink((named ? path_ : part_).c_str());
        fail_writing(path_, "cannot put in place", error);
    }
    sync_folder_of(path_);
}

}  // namespace photond
