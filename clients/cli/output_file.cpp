#include "clients/cli/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "clients/cli/failure.h"

namespace photond::cli {

namespace {
constexpr const char* kStandardOutput = "-";
}

OutputFile::OutputFile(std::filesystem::path path)
    : path_(std::move(path)), beside_(path_.string() + ".part" + std::to_string(getpid())) {
    if (path_ == kStandardOutput) {
        path_ = "standard output";
        beside_.clear();
        std::cout.flush();
        descriptor_ = STDOUT_FILENO;
        return;
    }
    std::error_code ignored;
    if (const auto status = std::filesystem::status(path_, ignored); std::filesystem::is_other(status)) {
        beside_.clear();  // a device or a pipe is written to: a file of its name would take its place
        descriptor_ = open(path_.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor_ < 0) fail("cannot write");
        return;
    }
    descriptor_ = open(beside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail("cannot write");
}

OutputFile::~OutputFile() {
    if (descriptor_ < 0 || descriptor_ == STDOUT_FILENO) return;
    close(descriptor_);
    if (!beside_.empty()) unlink(beside_.c_str());
}

void OutputFile::check_place(const std::filesystem::path& path) {
    if (path == kStandardOutput) return;
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    if (std::filesystem::is_other(status)) return;  // to open a pipe would wait for who reads it
    if (std::filesystem::is_directory(status))
        throw Failure(ExitCode::LocalFile, "cannot write " + path.string() + ": it is a folder");
    const OutputFile made(path);
}

void OutputFile::restart() {
    if (beside_.empty()) {
        if (size_bytes_ > 0) throw Failure(ExitCode::LocalFile, "what " + path_.string() + " has cannot be taken back");
        return;
    }
    if (ftruncate(descriptor_, 0) != 0 || lseek(descriptor_, 0, SEEK_SET) != 0) fail("cannot write");
    size_bytes_ = 0;
}

void OutputFile::write(std::string_view bytes) {
    size_bytes_ += bytes.size();
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail("cannot write");
        bytes.remove_prefix(static_cast<size_t>(count));
    }
}

void OutputFile::publish() {
    if (beside_.empty()) return;
    if (fsync(descriptor_) != 0) fail("cannot write");
    if (std::rename(beside_.c_str(), path_.c_str()) != 0) fail("cannot name");
    close(descriptor_);
    descriptor_ = -1;
}

void OutputFile::fail(const std::string& what) const {
    throw Failure(ExitCode::LocalFile, what + " " + path_.string() + ": " + std::strerror(errno));
}

}  // namespace photond::cli
