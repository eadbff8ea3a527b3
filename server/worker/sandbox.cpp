#include "server/worker/sandbox.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <malloc.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "protocol/error.h"
#include "server/worker/process_memory.h"
#include "server/workers/address_space.h"

namespace photond {

namespace {

constexpr int kMallocArenas = 4;  // each reserves 64 MiB of address space

[[noreturn]] void fail(const std::string& what, int error) {
    throw Error(ErrorCode::Internal, "the sandbox cannot be entered: " + what + ": " + std::strerror(error));
}

void bound(int resource, uint64_t value, const char* what) {
    rlimit limit{};
    if (getrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0) fail(what, errno);
    limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(value, limit.rlim_cur);
    if (setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0) fail(what, errno);
}

void die_with_parent(int parent_socket) {
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) fail("PR_SET_PDEATHSIG", errno);
    // The parent may have died before that call: it made the socket pair, whose credentials tell who it was.
    ucred creator{};
    socklen_t length = sizeof creator;
    if (getsockopt(parent_socket, SOL_SOCKET, SO_PEERCRED, &creator, &length) != 0) fail("SO_PEERCRED", errno);
    if (creator.pid != 0 && creator.pid != getppid())  // 0: made in a process namespace we do not see
        throw Error(ErrorCode::WorkerLost, "the process that started this worker is gone");
}

constexpr const char* kBecomeProgram = "execve";

/// System calls a renderer has no use for, whatever their arguments.
constexpr const char* kForbidden[] = {
    // the network
    "socket", "socketpair", "connect", "bind", "listen", "accept", "accept4",
    // other programs and processes
    kBecomeProgram, "execveat", "fork", "vfork", "ptrace", "process_vm_readv", "process_vm_writev", "pidfd_open",
    "pidfd_getfd", "pidfd_send_signal", "process_madvise", "kcmp", "rt_sigqueueinfo", "rt_tgsigqueueinfo",
    // rights, namespaces, the file system's shape
    "setuid", "setgid", "setreuid", "setregid", "setresuid", "setresgid", "setgroups", "setfsuid", "setfsgid", "capset",
    "chmod", "fchmod", "fchmodat", "fchmodat2", "chown", "fchown", "lchown", "fchownat", "setxattr", "lsetxattr",
    "fsetxattr", "removexattr", "lremovexattr", "fremovexattr", "utime", "utimes", "futimesat", "utimensat", "truncate",
    "inotify_init", "inotify_init1", "fanotify_init", "fanotify_mark", "unshare", "setns", "chroot", "pivot_root",
    "mount", "umount2", "open_tree", "move_mount", "fsopen", "fsmount", "mount_setattr", "name_to_handle_at",
    "open_by_handle_at", "mknod", "mknodat", "link", "linkat", "symlink", "symlinkat", "quotactl", "acct",
    // the kernel
    "bpf", "perf_event_open", "userfaultfd", "io_uring_setup", "io_uring_enter", "io_uring_register", "keyctl",
    "add_key", "request_key", "init_module", "finit_module", "delete_module", "kexec_load", "kexec_file_load", "reboot",
    "swapon", "swapoff", "sethostname", "setdomainname", "settimeofday", "clock_settime", "adjtimex", "clock_adjtime",
    "iopl", "ioperm", "syslog", "personality", "modify_ldt", "shmget", "shmat", "msgget", "semget"};

void forbid_system_calls(bool becomes_program) {
    const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_ALLOW), &seccomp_release);
    if (!filter) fail("seccomp_init", ENOMEM);
    const auto check = [](int status, const std::string& what) {
        if (status < 0) fail("seccomp, " + what, -status);
    };
    check(seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_TSYNC, 1), "all threads");
    for (const char* name : kForbidden) {
        if (becomes_program && name == kBecomeProgram) continue;
        const int call = seccomp_syscall_resolve_name(name);
        if (call == __NR_SCMP_ERROR) continue;  // younger than this library, or not of this processor
        check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 0), name);
    }
    // Threads yes, processes no. clone3 hides its flags in memory where a filter cannot look: "not there" makes the C
    // library fall back to clone.
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0), "clone3");
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), SCMP_SYS(clone), 1,
                           SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, 0)),
          "clone");
    // Signals to ourselves only (abort and raise use them).
    const auto self = static_cast<scmp_datum_t>(getpid());
    for (const int call : {SCMP_SYS(kill), SCMP_SYS(tgkill)})
        check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 1, SCMP_A0(SCMP_CMP_NE, self)), "kill");
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), SCMP_SYS(tkill), 0), "tkill");
    // Limits and scheduling of ourselves only; of another thread of ours they are refused with the rest.
    const auto of_self_only = [&](int call, unsigned argument, const char* name) {
        const scmp_arg_cmp ours{argument, SCMP_CMP_GT, 0, 0};
        check(seccomp_rule_add_array(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 1, &ours), name);
    };
    of_self_only(SCMP_SYS(prlimit64), 0, "prlimit64");
    of_self_only(SCMP_SYS(setpriority), 1, "setpriority");
    of_self_only(SCMP_SYS(ioprio_set), 1, "ioprio_set");
    of_self_only(SCMP_SYS(sched_setaffinity), 0, "sched_setaffinity");
    of_self_only(SCMP_SYS(sched_setscheduler), 0, "sched_setscheduler");
    of_self_only(SCMP_SYS(sched_setparam), 0, "sched_setparam");
    of_self_only(SCMP_SYS(sched_setattr), 0, "sched_setattr");
    // Cutting a file off while it is opened for reading, which Landlock's first two versions do not see. openat2 hides
    // its flags in memory: "not there" makes whoever tries it fall back to openat.
    check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(openat2), 0), "openat2");
    for (const auto& [call, argument] : {std::pair<int, unsigned>{SCMP_SYS(open), 1}, {SCMP_SYS(openat), 2}})
        for (const int mode : {O_RDONLY, O_ACCMODE}) {
            const scmp_arg_cmp cuts{argument, SCMP_CMP_MASKED_EQ, O_TRUNC | O_ACCMODE,
                                    static_cast<scmp_datum_t>(O_TRUNC | mode)};
            check(seccomp_rule_add_array(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 1, &cuts), "open");
        }
    // Typing into the terminal that standard error may be.
    for (const unsigned request : {TIOCSTI, TIOCLINUX})
        check(seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), SCMP_SYS(ioctl), 1,
                               SCMP_A1(SCMP_CMP_MASKED_EQ, 0xffffffffu, request)),
              "ioctl");
    check(seccomp_load(filter.get()), "loading the filter");
}

/// The kernel should end the render and not the daemon when the machine runs out of memory.
void volunteer_for_the_oom_killer() {
    const int file = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
    if (file < 0) return;
    [[maybe_unused]] const ssize_t written = write(file, "500", 3);  // refused: the kernel's own choice stands
    close(file);
}

}  // namespace

void bind_to_parent(int parent_socket) {
    for (const int ignored : {SIGTERM, SIGINT, SIGPIPE, SIGXFSZ}) signal(ignored, SIG_IGN);
    die_with_parent(parent_socket);
    bound(RLIMIT_CORE, 0, "RLIMIT_CORE");
    // Both need a file of /proc that is closed to a process which is not dumpable.
    volunteer_for_the_oom_killer();
    reset_peak_resident();
    if (prctl(PR_SET_DUMPABLE, 0) != 0) fail("PR_SET_DUMPABLE", errno);
}

void give_up_capabilities() {
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct have[_LINUX_CAPABILITY_U32S_3]{};
    if (syscall(SYS_capget, &header, have) != 0) fail("capget", errno);
    const uint32_t files = 1u << CAP_DAC_OVERRIDE | 1u << CAP_DAC_READ_SEARCH;
    have[0].effective &= files, have[0].permitted &= files, have[0].inheritable = 0;
    have[1] = {};
    if (syscall(SYS_capset, &header, have) != 0) fail("capset", errno);
}

void enter_sandbox(const SandboxLimits& limits) {
    bound(RLIMIT_FSIZE, limits.file_bytes, "RLIMIT_FSIZE");
#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // their shadow memory is terabytes of address space
    mallopt(M_ARENA_MAX, kMallocArenas);
    if (limits.bound_address_space)
        bound(RLIMIT_AS, virtual_bytes() + worker_address_space(limits.memory_bytes, limits.threads), "RLIMIT_AS");
#endif
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail("PR_SET_NO_NEW_PRIVS", errno);
    forbid_system_calls(limits.becomes_program);
}

}  // namespace photond
