// What a worker may not do once it is in the sandbox, tried in a child process, and what it still can.

#include "server/worker/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <functional>
#include <thread>

#include "protocol/error.h"

namespace photond::sandbox_test {
namespace {

constexpr uint64_t kFileBytes = 1 << 20;

/// Runs `attempt` in a child that is in the sandbox; returns its exit status, 200 when the sandbox could not be
/// entered. `threads_before` runs before it is, as a GPU's driver does.
int in_sandbox(
    const std::function<int()>& attempt, bool bound_address_space = true,
    const std::function<void()>& threads_before = [] {}) {
    int sockets[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0) return 201;
    const pid_t child = fork();
    if (child == 0) {
        close(sockets[0]);
        try {
            bind_to_parent(sockets[1]);
            threads_before();
            enter_sandbox({256ull << 20, kFileBytes, 2, bound_address_space});
        } catch (const std::exception& error) {
            fprintf(stderr, "%s\n", error.what());
            _exit(200);
        }
        _exit(attempt());
    }
    int status = 0;
    waitpid(child, &status, 0);
    close(sockets[0]), close(sockets[1]);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 300 + WTERMSIG(status);
}

/// The errno of a call that must fail; 0 when it went through.
int error_of(long result) { return result < 0 ? errno : 0; }

TEST(Sandbox, NoSocketsAndNoConnections) {
    EXPECT_EQ(in_sandbox([] { return error_of(socket(AF_INET, SOCK_STREAM, 0)); }), EPERM);
    EXPECT_EQ(in_sandbox([] { return error_of(socket(AF_UNIX, SOCK_STREAM, 0)); }), EPERM);
    // A socket that was there before cannot be connected either.
    const int before = socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(in_sandbox([before] {
                  sockaddr_in address{};
                  address.sin_family = AF_INET;
                  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
                  address.sin_port = htons(9);
                  return error_of(connect(before, reinterpret_cast<sockaddr*>(&address), sizeof address));
              }),
              EPERM);
    close(before);
}

TEST(Sandbox, NoOtherProgramsOrProcesses) {
    EXPECT_EQ(in_sandbox([] { return error_of(execl("/bin/true", "true", nullptr)); }), EPERM);
    EXPECT_EQ(in_sandbox([] {
                  const pid_t child = fork();
                  if (child == 0) _exit(0);
                  return error_of(child);
              }),
              EPERM);
    EXPECT_EQ(in_sandbox([] { return error_of(ptrace(PTRACE_TRACEME, 0, nullptr, nullptr)); }), EPERM);
    EXPECT_EQ(in_sandbox([] { return error_of(kill(getppid(), 0)); }), EPERM);
    EXPECT_EQ(in_sandbox([] { return error_of(setuid(getuid())); }), EPERM);
    EXPECT_EQ(in_sandbox([] { return error_of(symlink("/etc/passwd", "/tmp/photond_sandbox_link")); }), EPERM);
}

TEST(Sandbox, ThreadsAndFilesStillWork) {
    EXPECT_EQ(in_sandbox([] {
                  int value = 0;
                  std::thread([&] { value = 7; }).join();
                  const int file = open("/proc/self/statm", O_RDONLY);
                  return value == 7 && file >= 0 ? 42 : 1;
              }),
              42);
}

TEST(Sandbox, TheFilterHoldsForThreadsToo) {
    EXPECT_EQ(in_sandbox([] {
                  int error = 0;
                  std::thread([&] { error = error_of(socket(AF_INET, SOCK_STREAM, 0)); }).join();
                  return error;
              }),
              EPERM);
}

TEST(Sandbox, TheFilterHoldsForThreadsThatWereThereBefore) {
    std::atomic<bool> entered = false;
    std::atomic<int> error = 0, privileges = 0;
    std::thread earlier;
    const int result = in_sandbox(
        [&] {
            entered = true;
            earlier.join();
            return error == EPERM && privileges == 1 ? 42 : 1;
        },
        false,
        [&] {
            earlier = std::thread([&] {
                while (!entered) std::this_thread::yield();
                error = error_of(socket(AF_INET, SOCK_STREAM, 0));
                privileges = prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0);
            });
        });
    EXPECT_EQ(result, 42);
}

TEST(Sandbox, LimitsOfFilesCoresAndPrivileges) {
    EXPECT_EQ(in_sandbox([] {
                  FILE* file = tmpfile();  // SIGXFSZ is ignored: the write fails instead
                  const std::string bytes(2 * kFileBytes, 'x');
                  const ssize_t n = write(fileno(file), bytes.data(), bytes.size());
                  return n == ssize_t(kFileBytes) ? error_of(write(fileno(file), "x", 1)) : 1;
              }),
              EFBIG);
    EXPECT_EQ(in_sandbox([] {
                  rlimit core{};
                  getrlimit(RLIMIT_CORE, &core);
                  return core.rlim_max == 0 && prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0) == 1 ? 42 : 1;
              }),
              42);
}

TEST(Sandbox, SignalsThatEndProgramsAreIgnored) {
    EXPECT_EQ(in_sandbox([] {
                  raise(SIGTERM), raise(SIGINT), raise(SIGPIPE);
                  return 42;
              }),
              42);
    EXPECT_EQ(in_sandbox([]() -> int { abort(); }),
              300 + SIGABRT);  // a defect still ends the process, by its own signal
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Sandbox, AddressSpaceIsBounded) {
    EXPECT_EQ(in_sandbox([] {
                  void* memory = mmap(nullptr, 8ull << 30, PROT_READ | PROT_WRITE,
                                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
                  return memory == MAP_FAILED ? errno : 0;
              }),
              ENOMEM);
    EXPECT_EQ(in_sandbox(
                  [] {
                      void* memory = mmap(nullptr, 8ull << 30, PROT_READ | PROT_WRITE,
                                          MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
                      return memory == MAP_FAILED ? errno : 42;
                  },
                  false),
              42)
        << "a GPU's driver maps as wide as it likes";
}
#endif

TEST(Sandbox, DiesWithItsParent) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t parent = fork();
    if (parent == 0) {
        int sockets[2];
        if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0) _exit(1);
        if (fork() == 0) {
            bind_to_parent(sockets[1]);
            enter_sandbox({256ull << 20, kFileBytes, 2});
            close(pipe_ends[0]);
            if (write(pipe_ends[1], "r", 1) != 1) _exit(1);
            for (;;) pause();
        }
        close(pipe_ends[1]);
        char ready;
        _exit(read(pipe_ends[0], &ready, 1) == 1 ? 0 : 1);
    }
    close(pipe_ends[1]);
    int status = 0;
    waitpid(parent, &status, 0);
    ASSERT_EQ(WEXITSTATUS(status), 0);
    // The worker holds the pipe's other end: its end is ours to see as end of file.
    char nothing;
    EXPECT_EQ(read(pipe_ends[0], &nothing, 1), 0);
    close(pipe_ends[0]);
}

TEST(Sandbox, AParentThatIsGoneAlreadyIsNoticed) {
    int sockets[2], pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t maker = fork();
    if (maker == 0) {
        if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0) _exit(1);
        const pid_t middle = getpid();
        if (fork() == 0) {
            while (getppid() == middle) usleep(1000);  // until the maker is gone
            char seen = 'x';
            try {
                bind_to_parent(sockets[1]);
            } catch (const Error& error) {
                seen = error.code == ErrorCode::WorkerLost ? 'l' : 'e';
            }
            _exit(write(pipe_ends[1], &seen, 1) == 1 ? 0 : 1);
        }
        _exit(0);
    }
    waitpid(maker, nullptr, 0);
    char seen = '?';
    ASSERT_EQ(read(pipe_ends[0], &seen, 1), 1);
    EXPECT_EQ(seen, 'l');
    close(pipe_ends[0]), close(pipe_ends[1]);
}

}  // namespace
}  // namespace photond::sandbox_test
