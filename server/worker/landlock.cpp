#include "server/worker/landlock.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

// What is younger than Debian 12's header (the second version).
constexpr uint64_t kTruncate = 1ull << 14;     // third
constexpr uint64_t kNetTcp = 3;                // fourth: bind and connect
constexpr uint64_t kIoctlDevice = 1ull << 15;  // fifth
constexpr uint64_t kScopes = 3;                // sixth: abstract sockets and signals

struct RulesetAttributes {
    uint64_t files, network, scoped;
};

constexpr uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr uint64_t kRead = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr uint64_t kWriteFile = kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
constexpr uint64_t kWrite = kWriteFile | kRead | LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                            LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REFER;
constexpr uint64_t kDeviceFile = kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE | kIoctlDevice;

[[noreturn]] void fail(const std::string& what) {
    throw Error(ErrorCode::Internal, "Landlock: " + what + ": " + std::strerror(errno));
}

/// All rights over files that a version knows, which are those that are refused where no rule gives them.
uint64_t rights_of_version(int version) {
    uint64_t rights = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
    if (version >= 2) rights |= LANDLOCK_ACCESS_FS_REFER;
    if (version >= 3) rights |= kTruncate;
    if (version >= 5) rights |= kIoctlDevice;
    return rights;
}

uint64_t rights_of_use(FileUse use, bool folder) {
    switch (use) {
        case FileUse::Read: return folder ? kRead : kReadFile;
        case FileUse::Execute: return (folder ? kRead : kReadFile) | LANDLOCK_ACCESS_FS_EXECUTE;
        case FileUse::Write: return folder ? kWrite : kWriteFile;
        case FileUse::Device: return kDeviceFile | (folder ? LANDLOCK_ACCESS_FS_READ_DIR : 0);
    }
    return 0;
}

class Descriptor {
public:
    explicit Descriptor(long descriptor) : descriptor_(static_cast<int>(descriptor)) {}
    ~Descriptor() {
        if (descriptor_ >= 0) close(descriptor_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return descriptor_; }

private:
    int descriptor_;
};

}  // namespace

int landlock_version() {
    const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    const char* older = std::getenv("PHOTOND_LANDLOCK_VERSION");
    return std::max(0, std::min(static_cast<int>(version), older ? std::atoi(older) : 1 << 30));
}

void enter_landlock(int version, const std::vector<FileRule>& rules) {
    RulesetAttributes attributes{rights_of_version(version), version >= 4 ? kNetTcp : 0, version >= 6 ? kScopes : 0};
    const size_t size = version >= 6 ? sizeof attributes : version >= 4 ? 16 : 8;
    const Descriptor ruleset(syscall(SYS_landlock_create_ruleset, &attributes, size, 0));
    if (ruleset.get() < 0) fail("no ruleset");
    for (const FileRule& rule : rules) {
        const Descriptor file(open(rule.path.c_str(), O_PATH | O_CLOEXEC));
        struct stat entry {};
        if (file.get() < 0 || fstat(file.get(), &entry) != 0) fail(rule.path.string());
        landlock_path_beneath_attr beneath{};
        beneath.allowed_access = rights_of_use(rule.use, S_ISDIR(entry.st_mode)) & attributes.files;
        beneath.parent_fd = file.get();
        if (syscall(SYS_landlock_add_rule, ruleset.get(), LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) != 0)
            fail(rule.path.string());
    }
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail("PR_SET_NO_NEW_PRIVS");
    if (syscall(SYS_landlock_restrict_self, ruleset.get(), 0) != 0) fail("entering");
}

}  // namespace photond
