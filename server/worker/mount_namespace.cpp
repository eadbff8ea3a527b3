#include "server/worker/mount_namespace.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "protocol/error.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

constexpr const char* kBase = "/tmp";  // what is mounted here is seen by this process alone, and soon not even by it

void check(long result, const std::string& what) {
    if (result != 0) throw Error(ErrorCode::Internal, "a mount namespace: " + what + ": " + std::strerror(errno));
}

void write_line(const char* file, const std::string& text) {
    const int descriptor = open(file, O_WRONLY | O_CLOEXEC);
    const ssize_t written = descriptor < 0 ? -1 : write(descriptor, text.data(), text.size());
    const int error = errno;
    if (descriptor >= 0) close(descriptor);
    errno = error;
    check(written == static_cast<ssize_t>(text.size()) ? 0 : -1, file);
}

/// This user is the same one inside, and nobody else is anybody.
void enter_namespaces() {
    const std::string user = std::to_string(geteuid()), group = std::to_string(getegid());
    const bool dumpable = prctl(PR_GET_DUMPABLE) == 1;
    check(prctl(PR_SET_DUMPABLE, 1), "PR_SET_DUMPABLE");  // else these files belong to root
    check(unshare(CLONE_NEWUSER | CLONE_NEWNS), "unshare");
    write_line("/proc/self/setgroups", "deny");
    write_line("/proc/self/uid_map", user + " " + user + " 1");
    write_line("/proc/self/gid_map", group + " " + group + " 1");
    check(prctl(PR_SET_DUMPABLE, dumpable ? 1 : 0), "PR_SET_DUMPABLE");
}

/// An empty root; the old one lies at /old, what is to become the new one at /new.
void step_aside() {
    check(mount(nullptr, "/", nullptr, MS_REC | MS_SLAVE, nullptr), "no changes outside");
    check(mount("photond", kBase, "tmpfs", MS_NOSUID | MS_NODEV, "mode=0755,size=1m"), kBase);
    check(chdir(kBase), kBase);
    check(mkdir("old", 0755), "old");
    check(mkdir("new", 0755), "new");
    check(mount("new", "new", nullptr, MS_BIND, nullptr), "new");
    check(syscall(SYS_pivot_root, kBase, "old"), "pivot_root");
    check(chdir("/"), "/");
}

fs::path below(const char* root, const fs::path& path) { return fs::path(root) / path.relative_path(); }

/// The links on the way to a rule's file, such as /lib, lead where they lead outside.
void copy_links(const fs::path& path) {
    fs::path prefix;
    for (const fs::path& part : path) {
        prefix /= part;
        std::error_code error;
        if (!fs::is_symlink(below("/old", prefix), error)) continue;
        const fs::path link = below("/new", prefix);
        fs::create_directories(link.parent_path(), error);
        fs::create_symlink(fs::read_symlink(below("/old", prefix)), link, error);  // it may be there
        return;
    }
}

void show(const FileRule& rule) {
    const fs::path from = below("/old", rule.path), to = below("/new", rule.path);
    std::error_code error;
    if (!fs::exists(to, error)) {
        fs::create_directories(fs::is_directory(from) ? to : to.parent_path());
        if (!fs::is_directory(from)) close(open(to.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    }
    check(mount(from.c_str(), to.c_str(), nullptr, MS_BIND | MS_REC, nullptr), rule.path);
    mount_attr attributes{};
    attributes.attr_set = MOUNT_ATTR_NOSUID;
    if (rule.use == FileUse::Read || rule.use == FileUse::Execute) attributes.attr_set |= MOUNT_ATTR_RDONLY;
    check(mount_setattr(AT_FDCWD, to.c_str(), AT_RECURSIVE, &attributes, sizeof attributes), rule.path);
}

void make_the_new_root_all() {
    mount_attr attributes{};
    attributes.attr_set = MOUNT_ATTR_RDONLY;
    check(mount_setattr(AT_FDCWD, "/new", 0, &attributes, sizeof attributes), "read-only");
    check(chdir("/new"), "/new");
    check(syscall(SYS_pivot_root, ".", "."), "the new root");
    check(umount2(".", MNT_DETACH), "the old root");
    check(chdir("/"), "/");
}

void enter(const std::vector<FileRule>& rules) {
    const std::vector<FileRule> all = resolved(rules);
    enter_namespaces();
    step_aside();
    for (const FileRule& rule : rules) copy_links(fs::path(rule.path).lexically_normal());
    for (const FileRule& rule : all) show(rule);
    make_the_new_root_all();
}

/// What keeps a child from it; empty: nothing.
std::string tried(const std::vector<FileRule>& rules) {
    int ends[2];
    check(pipe2(ends, O_CLOEXEC), "pipe");
    const pid_t child = fork();
    if (child == 0) {
        std::string reason;
        try {
            enter(rules);
        } catch (const std::exception& error) {
            reason = error.what();
        }
        [[maybe_unused]] const ssize_t told = write(ends[1], reason.data(), reason.size());
        _exit(reason.empty() ? 0 : 1);
    }
    close(ends[1]);
    std::string reason(512, '\0');
    const ssize_t length = child < 0 ? 0 : read(ends[0], reason.data(), reason.size());
    reason.resize(length < 0 ? 0 : static_cast<size_t>(length));
    close(ends[0]);
    int status = -1;
    if (child > 0) waitpid(child, &status, 0);
    return status == 0 ? "" : reason.empty() ? "a mount namespace cannot be tried" : reason;
}

}  // namespace

std::string enter_mount_namespace(const std::vector<FileRule>& rules) {
    std::string reason = tried(rules);
    if (reason.empty()) enter(rules);
    return reason;
}

}  // namespace photond
