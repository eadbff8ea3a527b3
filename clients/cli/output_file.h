#pragma once
// Result files: written beside and renamed, so that a name never holds half a file. "-" is standard output,
// and devices and pipes are written to as they are.

#include <filesystem>
#include <string>
#include <string_view>

namespace photond::cli {

class OutputFile {
public:
    /// Throws Failure(LocalFile) when nothing can be written there.
    explicit OutputFile(std::filesystem::path path);
    /// Removes what was not published.
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Throws Failure(LocalFile) where a file of this name could not be made now; leaves nothing there.
    static void check_place(const std::filesystem::path& path);

    /// Begins again: a download is being repeated. Throws Failure(LocalFile) for standard output that has been written
    /// to.
    void restart();
    void write(std::string_view bytes);
    /// Gives the file its name. Throws Failure(LocalFile).
    void publish();
    uint64_t size_bytes() const { return size_bytes_; }

private:
    [[noreturn]] void fail(const std::string& what) const;

    std::filesystem::path path_;
    std::filesystem::path beside_;
    int descriptor_ = -1;
    uint64_t size_bytes_ = 0;
};

}  // namespace photond::cli
