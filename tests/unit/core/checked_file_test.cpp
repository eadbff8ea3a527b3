#include "renderer/core/checked_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "protocol/error.h"
#include "renderer/core/atomic_file.h"

namespace photond {
namespace {

namespace fs = std::filesystem;

/// A folder below `where` that goes with the test.
struct Folder {
    explicit Folder(const fs::path& where) {
        std::string name = (where / "photond_checked_XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~Folder() { fs::remove_all(path); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    fs::path path;
};

std::string text_of(size_t bytes) {
    std::string text(bytes, '\0');
    for (size_t i = 0; i < bytes; ++i) text[i] = static_cast<char>(i * 31 + i / 4096);
    return text;
}

void write(const fs::path& path, const std::string& text, size_t piece) {
    CheckedFile file(path);
    for (size_t i = 0; i < text.size(); i += piece) file.write(text.data() + i, std::min(piece, text.size() - i));
    file.commit();
}

std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(CheckedFile, HoldsWhatWasWrittenOnADiskAndInMemory) {
    for (const char* where : {".", "/dev/shm"}) {  // the second has no way past the system's cache
        if (!fs::is_directory(where)) continue;
        const Folder folder(where);
        const fs::path path = folder.path / "file";
        for (const size_t bytes : {0ul, 1ul, 4095ul, 4096ul, 4097ul, 1048576ul, 1048577ul, 3000000ul})
            for (const size_t piece : {4096ul, 100000ul, 5000000ul}) {
                const std::string text = text_of(bytes);
                write(path, text, piece);
                ASSERT_EQ(read(path), text) << bytes << " bytes by " << piece << " in " << where;
                EXPECT_FALSE(fs::exists(AtomicFile::part_of(path)));
            }
    }
}

TEST(CheckedFile, LeavesWhatWasThereUntilItIsCommitted) {
    const Folder folder(".");
    const fs::path path = folder.path / "file";
    write(path, "before", 6);
    {
        CheckedFile file(path);
        const std::string more = text_of(2000000);
        file.write(more.data(), more.size());
        EXPECT_EQ(read(path), "before");
    }
    EXPECT_EQ(read(path), "before");
    EXPECT_FALSE(fs::exists(AtomicFile::part_of(path))) << "nothing stays of it";
    write(path, "after", 5);
    EXPECT_EQ(read(path), "after");
}

TEST(CheckedFile, SaysThatThereIsNoRoomAndLeavesNothing) {
    const Folder folder(".");
    const fs::path path = folder.path / "file";
    signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit little{1500000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &little);
    try {
        write(path, text_of(3000000), 3000000);
        ADD_FAILURE() << "it is larger than files may be";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::NoSpace) << error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_TRUE(fs::is_empty(folder.path));
}

}  // namespace
}  // namespace photond
