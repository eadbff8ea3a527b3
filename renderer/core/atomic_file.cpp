#include "renderer/core/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "protocol/error.h"

namespace photond {

namespace {

/// Of a stream that somebody else wrote to, who did not keep the reason: it is met again by writing a little more.
int error_of_writing(int descriptor) {
    constexpr std::array<char, 4096> kPage{};
    if (lseek(descriptor, 0, SEEK_END) < 0) return errno;
    for (int i = 0; i < 2; ++i)  // the first may fill up a page that there was room for
        if (::write(descriptor, kPage.data(), kPage.size()) != static_cast<ssize_t>(kPage.size())) return errno;
    return 0;
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& path) : path_(path), part_(part_of(path)) {
    const int descriptor = open(part_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (descriptor < 0) fail("cannot create", errno);
    file_ = fdopen(descriptor, "w+b");
    if (!file_) {
        const int error = errno;
        close(descriptor), unlink(part_.c_str());
        fail("cannot open a stream on", error);
    }
    constexpr size_t kBufferBytes = 1u << 20;  // a film is megabytes, and each write a call of the system
    setvbuf(file_, nullptr, _IOFBF, kBufferBytes);
}

AtomicFile::~AtomicFile() {
    if (!file_) return;
    fclose(file_);
    unlink(part_.c_str());
}

void AtomicFile::write(const void* data, size_t bytes) {
    if (bytes == 0) return;  // an empty array may lie nowhere
    if (fwrite(data, 1, bytes, file_) != bytes) fail("cannot write", errno);
}

void AtomicFile::flush() {
    errno = 0;
    if (fflush(file_) != 0 || ferror(file_)) fail("cannot write", errno != 0 ? errno : error_of_writing(fileno(file_)));
}

void AtomicFile::commit() {
    flush();
    if (fsync(fileno(file_)) != 0) fail("cannot sync", errno);
    FILE* const file = file_;
    file_ = nullptr;
    if (fclose(file) != 0 || rename(part_.c_str(), path_.c_str()) != 0) {
        const int error = errno;
        unlink(part_.c_str());
        fail("cannot put in place", error);
    }
    sync_folder();
}

void AtomicFile::commit_checked() {
    flush();
    // Not every file system can refuse to replace a file.
    if (renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) != 0) return commit();
    FILE* const file = file_;
    file_ = nullptr;
    const int status = fsync(fileno(file)), error = errno;
    if (fclose(file) != 0 || status != 0) {
        const int why = status != 0 ? error : errno;
        unlink(path_.c_str());
        fail("cannot sync", why);
    }
    sync_folder();
}

void AtomicFile::sync_folder() const {
    const int folder = open(path_.parent_path().empty() ? "." : path_.parent_path().c_str(), O_RDONLY | O_CLOEXEC);
    if (folder < 0) fail("cannot open the folder of", errno);
    const int status = fsync(folder), error = errno;
    close(folder);
    if (status != 0) fail("cannot sync the folder of", error);
}

void AtomicFile::fail(const char* what, int error) const {
    const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
    throw Error(full ? ErrorCode::NoSpace : ErrorCode::Internal,
                std::string(what) + " " + path_.filename().string() + ": " + std::strerror(error));
}

}  // namespace photond
