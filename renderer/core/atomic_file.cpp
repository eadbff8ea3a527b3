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
    if (descriptor < 0) fail_writing(path_, "cannot create", errno);
    file_ = fdopen(descriptor, "w+b");
    if (!file_) {
        const int error = errno;
        close(descriptor), unlink(part_.c_str());
        fail_writing(path_, "cannot open a stream on", error);
    }
}

AtomicFile::~AtomicFile() {
    if (!file_) return;
    fclose(file_);
    unlink(part_.c_str());
}

void AtomicFile::write(const void* data, size_t bytes) {
    if (bytes == 0) return;  // an empty array may lie nowhere
    if (fwrite(data, 1, bytes, file_) != bytes) fail_writing(path_, "cannot write", errno);
}

void AtomicFile::commit() {
    errno = 0;
    if (fflush(file_) != 0 || ferror(file_))
        fail_writing(path_, "cannot write", errno != 0 ? errno : error_of_writing(fileno(file_)));
    if (fsync(fileno(file_)) != 0) fail_writing(path_, "cannot sync", errno);
    FILE* const file = file_;
    file_ = nullptr;
    if (fclose(file) != 0 || rename(part_.c_str(), path_.c_str()) != 0) {
        const int error = errno;
        unlink(part_.c_str());
        fail_writing(path_, "cannot put in place", error);
    }
    sync_folder_of(path_);
}

void fail_writing(const std::filesystem::path& path, const char* what, int error) {
    const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
    throw Error(full ? ErrorCode::NoSpace : ErrorCode::Internal,
                std::string(what) + " " + path.filename().string() + ": " + std::strerror(error));
}

void sync_folder_of(const std::filesystem::path& path) {
    const int folder = open(path.parent_path().empty() ? "." : path.parent_path().c_str(), O_RDONLY | O_CLOEXEC);
    if (folder < 0) fail_writing(path, "cannot open the folder of", errno);
    const int status = fsync(folder), error = errno;
    close(folder);
    if (status != 0) fail_writing(path, "cannot sync the folder of", error);
}

}  // namespace photond
