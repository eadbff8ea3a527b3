#include "server/workers/spawn.h"

#include <fcntl.h>
#include <linux/close_range.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "protocol/error.h"
#include "protocol/message_channel.h"

namespace photond {

namespace {

/// Runs in the child of a program with threads: only what is safe in a signal handler may be called. Never returns.
[[noreturn]] void become(const char* program, char* const* arguments, int socket, Priority priority, pid_t parent) {
    // The parent may have died before the request below took hold.
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || getppid() != parent) _exit(126);
    setpgid(0, 0);  // a Ctrl-C at the terminal is for the daemon, which ends its children in order

    struct sigaction fallback {};
    fallback.sa_handler = SIG_DFL;
    for (int signal = 1; signal < NSIG; ++signal)
        if (signal != SIGKILL && signal != SIGSTOP) sigaction(signal, &fallback, nullptr);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);

    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + priority.nice);
    const sched_param lowest{};
    if (priority.background) sched_setscheduler(0, SCHED_IDLE, &lowest);

    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) _exit(126);
    // Standard output belongs to the daemon's one line.
    if (dup2(STDERR_FILENO, STDOUT_FILENO) < 0) _exit(126);
    // dup2 of a descriptor on itself would leave close-on-exec set.
    if (socket == kWorkerSocket) {
        if (fcntl(socket, F_SETFD, 0) != 0) _exit(126);
    } else if (dup2(socket, kWorkerSocket) < 0) {
        _exit(126);
    }
    if (close_range(kWorkerSocket + 1, ~0u, 0) != 0) _exit(126);
    execv(program, arguments);
    _exit(127);
}

}  // namespace

Child spawn_child(const std::filesystem::path& program, const std::vector<std::string>& arguments, Priority priority) {
    int sockets[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0)
        throw Error(ErrorCode::Internal, std::string("socketpair: ") + std::strerror(errno));

    std::vector<char*> words;
    std::string first = program.string();
    std::vector<std::string> rest = arguments;
    words.push_back(first.data());
    for (std::string& argument : rest) words.push_back(argument.data());
    words.push_back(nullptr);

    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid == 0) become(first.c_str(), words.data(), sockets[1], priority, parent);
    const int error = errno;
    close(sockets[1]);
    if (pid < 0) {
        close(sockets[0]);
        throw Error(ErrorCode::Internal, std::string("fork: ") + std::strerror(error));
    }
    return {pid, sockets[0]};
}

}  // namespace photond
