// What somebody could do who has taken a worker over, tried from inside the sandbox: under the newest version of
// Landlock that the kernel has, under the second (Debian 12's), and under none, where a mount namespace stands in.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "server/worker/file_access.h"
#include "server/worker/landlock.h"
#include "server/worker/sandbox.h"
#include "server/worker/video_encoder.h"

namespace photond::forbidden_acts_test {
namespace {

namespace fs = std::filesystem;

/// A daemon's data folder, its token file beside it, and a process that stands for the daemon.
struct Daemon {
    fs::path base, data, scenes, films, store, tokens, scene, film;
    pid_t pid = -1;
    char secret[16] = "a bearer token";

    Daemon() {
        std::string name = (fs::temp_directory_path() / "photond_acts_XXXXXX").string();
        base = mkdtemp(name.data());
        data = base / "data", scenes = data / "scenes", films = data / "films";
        store = data / "store.sqlite", tokens = base / "tokens", scene = scenes / "a.glb", film = films / "J1.film";
        fs::create_directories(scenes);
        fs::create_directories(films);
        for (const fs::path& file : {store, tokens, scene, film}) std::ofstream(file) << secret;
        int ready[2];
        if (pipe(ready) != 0) return;
        pid = fork();
        if (pid == 0) {
            prctl(PR_SET_DUMPABLE, 0);
            close(ready[0]), close(ready[1]);
            for (;;) pause();
        }
        close(ready[1]);
        char nothing;
        [[maybe_unused]] const ssize_t closed = read(ready[0], &nothing, 1);  // it is as it should be by now
        close(ready[0]);
    }
    ~Daemon() {
        kill(pid, SIGKILL);
        waitpid(pid, nullptr, 0);
        fs::remove_all(base);
    }
    Daemon(const Daemon&) = delete;
    Daemon& operator=(const Daemon&) = delete;
};

/// 0 when the call went through, else its errno.
int error_of(long result) { return result < 0 ? errno : 0; }

int error_of_open(const fs::path& path, int flags) {
    const int file = open(path.c_str(), flags | O_CLOEXEC, 0600);
    const int error = error_of(file);
    if (file >= 0) close(file);
    return error;
}

/// ENOENT where the folder can be listed and has no such entry.
int error_of_listing(const fs::path& folder, const char* name) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
        if (entry.path().filename() == name) return 0;
    return error ? error.value() : ENOENT;
}

int error_of_process(pid_t child) {
    const int error = error_of(child);
    if (child == 0) _exit(0);
    if (child > 0) waitpid(child, nullptr, 0);
    return error;
}

struct Act {
    const char* name;
    std::function<int(const Daemon&)> attempt;
    bool by_anybody = false;  // any process of the user can do it that is in no sandbox
};

std::string of_process(const Daemon& daemon, const char* file) {
    return "/proc/" + std::to_string(daemon.pid) + "/" + file;
}

const std::vector<Act>& acts() {
    static const std::vector<Act> all{
        {"read the store", [](auto& d) { return error_of_open(d.store, O_RDONLY); }, true},
        {"write the store", [](auto& d) { return error_of_open(d.store, O_RDWR); }, true},
        {"append to the store", [](auto& d) { return error_of_open(d.store, O_WRONLY | O_APPEND); }, true},
        {"truncate the store", [](auto& d) { return error_of(truncate(d.store.c_str(), 0)); }, true},
        {"open the store for reading and cut it off",
         [](auto& d) { return error_of_open(d.store, O_RDONLY | O_TRUNC); }, true},
        {"the same by openat2",
         [](auto& d) {
             const std::array<uint64_t, 3> how{O_RDONLY | O_TRUNC, 0, 0};
             return error_of(syscall(SYS_openat2, AT_FDCWD, d.store.c_str(), how.data(), sizeof how));
         },
         true},
        {"remove the store", [](auto& d) { return error_of(unlink(d.store.c_str())); }, true},
        {"move the store among the films",
         [](auto& d) { return error_of(rename(d.store.c_str(), (d.films / "x").c_str())); }, true},
        {"put a film in the store's place", [](auto& d) { return error_of(rename(d.film.c_str(), d.store.c_str())); },
         true},
        {"exchange film and store",
         [](auto& d) {
             return error_of(syscall(SYS_renameat2, AT_FDCWD, d.film.c_str(), AT_FDCWD, d.store.c_str(), 2));
         },
         true},
        {"link the store among the films",
         [](auto& d) { return error_of(link(d.store.c_str(), (d.films / "x").c_str())); }, true},
        {"lay a link to the store among the films",
         [](auto& d) { return error_of(symlink(d.store.c_str(), (d.films / "x").c_str())); }, true},
        {"make a file beside the store",
         [](auto& d) { return error_of_open(d.data / "store.sqlite-journal", O_WRONLY | O_CREAT); }, true},
        {"make a folder beside the store", [](auto& d) { return error_of(mkdir((d.data / "x").c_str(), 0700)); }, true},
        {"find the store in the data folder", [](auto& d) { return error_of_listing(d.data, "store.sqlite"); }, true},
        {"open the store to whoever likes", [](auto& d) { return error_of(chmod(d.store.c_str(), 0666)); }, true},
        {"give the store away", [](auto& d) { return error_of(chown(d.store.c_str(), getuid(), getgid())); }, true},
        {"change the store's times", [](auto& d) { return error_of(utimensat(AT_FDCWD, d.store.c_str(), nullptr, 0)); },
         true},
        {"set an attribute of the store",
         [](auto& d) { return error_of(setxattr(d.store.c_str(), "user.photond", "x", 1, 0)); }},
        {"change a scene", [](auto& d) { return error_of_open(d.scene, O_WRONLY); }, true},
        {"remove a scene", [](auto& d) { return error_of(unlink(d.scene.c_str())); }, true},
        {"add a scene", [](auto& d) { return error_of_open(d.scenes / "b.glb", O_WRONLY | O_CREAT); }, true},
        {"read the tokens", [](auto& d) { return error_of_open(d.tokens, O_RDONLY); }, true},
        {"read the users of the machine", [](auto&) { return error_of_open("/etc/passwd", O_RDONLY); }, true},
        {"leave a file in the temporary folder",
         [](auto& d) { return error_of_open(d.base / "left", O_WRONLY | O_CREAT); }, true},
        {"write the daemon's memory", [](auto& d) { return error_of_open(of_process(d, "mem"), O_RDWR); }},
        {"read the daemon's environment", [](auto& d) { return error_of_open(of_process(d, "environ"), O_RDONLY); }},
        {"open what the daemon has open", [](auto& d) { return error_of_open(of_process(d, "fd/0"), O_RDONLY); }},
        {"see where the daemon's memory lies", [](auto& d) { return error_of_open(of_process(d, "maps"), O_RDONLY); }},
        {"walk through the daemon's root",
         [](auto& d) { return error_of_open(of_process(d, "root") + d.store.string(), O_RDONLY); }},
        {"read the daemon's memory by process_vm_readv",
         [](auto& d) {
             std::array<char, sizeof d.secret> bytes{};
             const iovec ours{bytes.data(), bytes.size()}, theirs{const_cast<char*>(d.secret), sizeof d.secret};
             return error_of(process_vm_readv(d.pid, &ours, 1, &theirs, 1, 0));
         }},
        {"debug the daemon", [](auto& d) { return error_of(ptrace(PTRACE_SEIZE, d.pid, nullptr, nullptr)); }},
        {"end the daemon", [](auto& d) { return error_of(kill(d.pid, 0)); }, true},
        {"stop all processes", [](auto&) { return error_of(kill(-1, 0)); }},
        {"bound the daemon's memory",
         [](auto& d) {
             const rlimit little{1 << 20, 1 << 20};
             return error_of(prlimit(d.pid, RLIMIT_AS, &little, nullptr));
         },
         true},
        {"slow the daemon down", [](auto& d) { return error_of(setpriority(PRIO_PROCESS, d.pid, 19)); }, true},
        {"open a connection", [](auto&) { return error_of(socket(AF_INET, SOCK_STREAM, 0)); }, true},
        {"open a local connection", [](auto&) { return error_of(socket(AF_UNIX, SOCK_STREAM, 0)); }, true},
        {"start a program",
         [](auto&) { return error_of(execl("/nothing/there", "there", nullptr)) == ENOENT ? 0 : errno; }, true},
        {"start a process", [](auto&) { return error_of_process(fork()); }, true},
        {"mount something", [](auto& d) { return error_of(mount("x", d.films.c_str(), "tmpfs", 0, nullptr)); }},
        {"become root of a namespace", [](auto&) { return error_of(unshare(CLONE_NEWUSER)); }},
        {"be spared when memory runs out", [](auto&) { return error_of_open("/proc/self/oom_score_adj", O_WRONLY); },
         true},
        {"set the kernel's parameters", [](auto&) { return error_of_open("/proc/sys/kernel/core_pattern", O_WRONLY); }},
        {"type into the terminal", [](auto&) { return error_of(ioctl(0, TIOCSTI, "x")) == ENOTTY ? 0 : errno; }, true},
    };
    return all;
}

/// What a worker's work needs.
const std::vector<Act>& duties() {
    static const std::vector<Act> all{
        {"read a scene", [](auto& d) { return error_of_open(d.scene, O_RDONLY); }},
        {"list the scenes", [](auto& d) { return error_of_open(d.scenes, O_RDONLY | O_DIRECTORY); }},
        {"read a film", [](auto& d) { return error_of_open(d.film, O_RDONLY); }},
        {"write a film anew", [](auto& d) { return error_of_open(d.film, O_WRONLY | O_CREAT | O_TRUNC); }},
        {"make a film", [](auto& d) { return error_of_open(d.films / "J2.part", O_WRONLY | O_CREAT | O_EXCL); }},
        {"put it in its place",
         [](auto& d) { return error_of(rename((d.films / "J2.part").c_str(), (d.films / "J2.film").c_str())); }},
        {"remove it", [](auto& d) { return error_of(unlink((d.films / "J2.film").c_str())); }},
        {"throw words away", [](auto&) { return error_of_open("/dev/null", O_WRONLY); }},
        {"draw random bytes", [](auto&) { return error_of_open("/dev/urandom", O_RDONLY); }},
        {"measure its memory", [](auto&) { return error_of_open("/proc/self/statm", O_RDONLY); }},
        {"measure its threads", [](auto&) { return error_of_open("/proc/self/task", O_RDONLY | O_DIRECTORY); }},
        {"load a library", [](auto&) { return error_of_open("/etc/ld.so.cache", O_RDONLY); }},
    };
    return all;
}

struct Told {
    std::array<char, 32> by{};
    std::array<int, 64> errors{};  // of each act; -1: it was not tried
    int status = 0;                // that the child ended with
};

/// Tries acts in a child, in the sandbox of a worker where there is a version to take the kernel's Landlock for; of one
/// that is to become `program` where that is given.
Told in_child(const Daemon& daemon, const std::vector<Act>& tried, const char* version, const fs::path& program = {}) {
    Told told;
    told.errors.fill(-1);
    int sockets[2], ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0 || pipe(ends) != 0) return told;
    const pid_t child = fork();
    if (child == 0) {
        std::string by = "no sandbox";
        try {
            if (version) {
                setenv("PHOTOND_LANDLOCK_VERSION", version, 1);
                bind_to_parent(sockets[1]);
                std::vector<FileRule> rules = library_files();
                rules.push_back({daemon.scenes, FileUse::Read, true});
                rules.push_back({daemon.films, FileUse::Write, true});
                if (!program.empty())
                    for (FileRule& rule : video_encoder_files(program)) rules.push_back(std::move(rule));
                const FileAccess access = bound_file_access(rules);
                by = access.by + (access.version ? " " + std::to_string(*access.version) : "");
                give_up_capabilities();
                enter_sandbox({256ull << 20, 1 << 20, 2, true, !program.empty()});
            }
            by.copy(told.by.data(), told.by.size() - 1);
            for (size_t k = 0; k < tried.size(); ++k) told.errors[k] = tried[k].attempt(daemon);
        } catch (const std::exception& error) {
            std::string(error.what()).copy(told.by.data(), told.by.size() - 1);
        }
        [[maybe_unused]] const ssize_t written = write(ends[1], &told, sizeof told);
        if (!program.empty()) execl(program.c_str(), program.c_str(), nullptr);
        _exit(126);
    }
    close(ends[1]), close(sockets[1]);
    if (read(ends[0], &told, sizeof told) != sizeof told)
        std::string("the child was lost").copy(told.by.data(), told.by.size() - 1);
    close(ends[0]), close(sockets[0]);
    waitpid(child, &told.status, 0);
    return told;
}

void expect_forbidden(const char* version, const std::string& by) {
    const Daemon daemon;
    const Told forbidden = in_child(daemon, acts(), version);
    if (forbidden.by.data() == std::string(FileAccess::kNone))
        GTEST_SKIP() << "this machine has nothing to bound files with";
    ASSERT_EQ(forbidden.by.data(), by);
    for (size_t k = 0; k < acts().size(); ++k) EXPECT_GT(forbidden.errors[k], 0) << by << ": " << acts()[k].name;
    const Told allowed = in_child(daemon, duties(), version);
    for (size_t k = 0; k < duties().size(); ++k) EXPECT_EQ(allowed.errors[k], 0) << by << ": " << duties()[k].name;
}

TEST(ForbiddenActs, AreThirtyAtLeastAndPossibleOutside) {
    ASSERT_GE(acts().size(), 30u);
    for (const Act& act : acts()) {
        if (!act.by_anybody) continue;  // the machine itself may refuse it
        const Daemon daemon;
        const Told told = in_child(daemon, {act}, nullptr);
        EXPECT_EQ(told.errors[0], 0) << act.name << ": " << std::strerror(told.errors[0]);
    }
}

TEST(ForbiddenActs, UnderTheNewestLandlock) {
    const int version = landlock_version();
    if (version == 0) GTEST_SKIP() << "this kernel has no Landlock";
    expect_forbidden("1000", "landlock " + std::to_string(version));
}

TEST(ForbiddenActs, UnderItsSecondVersion) {
    if (landlock_version() < 2) GTEST_SKIP() << "this kernel has no second version of Landlock";
    expect_forbidden("2", "landlock 2");
}

TEST(ForbiddenActs, OfAProcessThatBecomesAnotherProgramAreTheSameAndItBecomesNoThird) {
    if (landlock_version() == 0) GTEST_SKIP() << "this kernel has no Landlock";
    const char* const kProgram = "/usr/bin/true";
    std::vector<Act> tried;
    for (const Act& act : acts())
        if (act.name != std::string("start a program")) tried.push_back(act);
    tried.push_back(
        {"become a third program", [](auto&) { return error_of(execl("/usr/bin/false", "false", nullptr)); }});
    tried.push_back({"become one that lies among the films",
                     [](auto& d) { return error_of(execl((d.films / "own").c_str(), "own", nullptr)); }});
    const Daemon daemon;
    fs::copy_file("/usr/bin/false", daemon.films / "own");
    const Told told = in_child(daemon, tried, "1000", kProgram);
    for (size_t k = 0; k < tried.size(); ++k) EXPECT_GT(told.errors[k], 0) << tried[k].name;
    EXPECT_TRUE(WIFEXITED(told.status) && WEXITSTATUS(told.status) == 0) << "it is to become " << kProgram;
}

TEST(ForbiddenActs, WithoutLandlock) { expect_forbidden("0", "mount_namespace"); }

}  // namespace
}  // namespace photond::forbidden_acts_test
