// photond: flags, signals, wiring; nothing else.

#include <arpa/inet.h>
#include <malloc.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>

#include "server/auth.h"
#include "server/routes/http_server.h"
#include "server/routes/listener.h"
#include "server/service.h"
#include "server/service/inspection.h"
#include "server/workers/address_space.h"

namespace {

using namespace photond;
namespace fs = std::filesystem;

constexpr int kFaultsFound = 2;  // exit status of --check

/// "ADDRESS:PORT", an IPv6 address in brackets.
void parse_listen(const std::string& text, Options& options) {
    const size_t colon = text.rfind(':');
    int port = -1;
    if (colon != std::string::npos) {
        const char* end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data() + colon + 1, end, port);
        if (error != std::errc() || stopped != end) port = -1;
    }
    std::string address = text.substr(0, std::min(colon, text.size()));
    if (address.size() > 2 && address.front() == '[' && address.back() == ']')
        address = address.substr(1, address.size() - 2);
    if (port < 0 || port > 65535 || address.empty())
        throw Error(ErrorCode::OutOfRange, "--listen " + text + " is not ADDRESS:PORT");
    options.listen_address = address == "localhost" ? "127.0.0.1" : address;
    options.listen_port = port;
}

bool is_loopback(const std::string& address) {
    in_addr four{};
    in6_addr six{};
    if (inet_pton(AF_INET, address.c_str(), &four) == 1) return (ntohl(four.s_addr) >> 24) == 127;
    return inet_pton(AF_INET6, address.c_str(), &six) == 1 && IN6_IS_ADDR_LOOPBACK(&six);
}

fs::path default_data_dir() {
    const char* home = std::getenv("HOME");
    return fs::path(home && *home ? home : "/var/lib") / ".local/share/photond";
}

uint64_t machine_memory_bytes() {
    return static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void add_limits(CLI::App& app, Limits& limits) {
    const auto add = [&app](const char* name, auto& value, const char* type, const char* text) {
        return app.add_option(name, value, text)->type_name(type)->capture_default_str()->group("Limits");
    };
    const auto at_least_0 = CLI::NonNegativeNumber.description(""), above_0 = CLI::PositiveNumber.description("");
    add("--max-body", limits.max_body_bytes, "BYTES", "bytes of an upload");
    add("--max-json", limits.max_json_bytes, "BYTES", "bytes of a JSON body");
    add("--max-pixels", limits.max_pixels, "INT",
        "pixels of a job's image, width times height; a side has at most 65536");
    add("--max-queue", limits.max_queue, "INT", "jobs waiting");
    add("--max-connections", limits.max_connections, "INT", "connections open at once");
    add("--max-rate", limits.max_requests_per_second, "NUMBER",
        "requests per second of one token, or of one address without; 0: no limit")
        ->check(at_least_0);
    add("--answer-memory", limits.answer_memory_bytes, "BYTES",
        "bytes of answers that lie in memory until they are read")
        ->check(above_0);
    add("--disk-reserve", limits.disk_reserve_bytes, "BYTES", "bytes of disk never used");
    add("--max-job-seconds", limits.max_job_seconds, "SECONDS", "seconds one attempt may take; 0: no limit")
        ->check(at_least_0);
    add("--head-timeout", limits.head_timeout_seconds, "SECONDS", "seconds for a request's head")->check(above_0);
    add("--body-timeout", limits.body_timeout_seconds, "SECONDS", "seconds for a request's body")->check(above_0);
    add("--heartbeat-timeout", limits.heartbeat_timeout_seconds, "SECONDS", "seconds a worker may be silent")
        ->check(above_0);
    add("--helper-timeout", limits.helper_timeout_seconds, "SECONDS", "seconds to judge or encode one thing")
        ->check(above_0);
    add("--grace", limits.shutdown_grace_seconds, "SECONDS", "seconds from SIGTERM to the end")->check(above_0);
    add("--cache-bytes", limits.artefact_cache_bytes, "BYTES", "bytes of encoded images kept");
}

/// Makes the settings whole; throws photond::Error where they contradict each other.
void complete(Options& options) {
    if (!is_loopback(options.listen_address) && options.token_file.empty())
        throw Error(ErrorCode::Forbidden,
                    "will not listen on " + options.listen_address + ", which others can reach, without --tokens FILE");
    options.worker_program = fs::read_symlink("/proc/self/exe").parent_path() / "photond-worker";
    if (access(options.worker_program.c_str(), X_OK) != 0)
        throw Error(ErrorCode::Internal, "there is no program " + options.worker_program.string());
    const unsigned threads = options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    options.memory_limit_bytes =
        memory_limit_within(granted_address_space(), options.memory_limit_bytes, machine_memory_bytes(), threads);
}

void make_data_folder(Options& options) {
    std::error_code error;
    fs::create_directories(options.data_dir, error);
    if (error) throw Error(ErrorCode::Internal, options.data_dir.string() + ": " + error.message());
    options.data_dir = fs::canonical(options.data_dir);
}

int serve(const Options& options, http::Listener listener, const sigset_t& signals) {
    std::optional<TokenList> tokens;
    if (!options.token_file.empty()) tokens = TokenList::load(options.token_file);
    Service service(options);
    HttpServer server(service, tokens ? &*tokens : nullptr, std::move(listener));
    server.start();
    std::printf("photond listening on %s\n", server.url().c_str());
    std::fflush(stdout);

    int signal = 0;
    sigwait(&signals, &signal);
    spdlog::info("{}: stopping", sigdescr_np(signal));
    const auto begun = std::chrono::steady_clock::now();
    service.stop();  // requests are still answered: no new jobs, everything else as ever
    const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    server.stop(std::clamp(options.limits.shutdown_grace_seconds - spent, 0.5, 2.0));
    return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
    spdlog::set_default_logger(spdlog::stderr_logger_mt("photond"));
    spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %l %v");

    // The allocator would keep what long answers have freed: blocks from this size on go back to the system at once,
    // and threads share a few arenas, which AnswerMemory trims.
    mallopt(M_MMAP_THRESHOLD, 64 << 10);
    mallopt(M_TRIM_THRESHOLD, 1 << 20);
    mallopt(M_ARENA_MAX, 4);

    // Before the first thread: all of them inherit it, and only sigwait() sees these.
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    prctl(PR_SET_DUMPABLE, 0);  // its memory holds tokens: no other process of this user looks into it
    umask(S_IRWXG | S_IRWXO);   // scenes, results and keys are for this user alone, the workers' files too

    Options options;
    options.data_dir = default_data_dir();
    std::string listen = "127.0.0.1:8080", log_level = "info", new_token;
    bool check = false, repair = false;
    CLI::App app{"Global-illumination render service", "photond"};
    app.get_formatter()->column_width(38);
    app.set_version_flag("--version", std::string("photond ") + PHOTOND_VERSION);
    app.add_option("--data", options.data_dir, "folder of everything the service keeps")
        ->type_name("FOLDER")
        ->default_str("~/.local/share/photond");
    app.add_option("--listen", listen, "where it can be reached; port 0 picks a free one")
        ->type_name("ADDRESS:PORT")
        ->capture_default_str();
    app.add_option("--devices", options.devices, "one worker process each")
        ->type_name("DEVICE,DEVICE")
        ->expected(1)
        ->delimiter(',')
        ->take_all()
        ->default_str("cpu");
    app.add_option("--memory-limit", options.memory_limit_bytes, "bytes a job may hold in a worker")
        ->type_name("BYTES")
        ->default_str("75 % of RAM, or what ulimit -v leaves");
    app.add_option("--threads", options.threads, "threads of each CPU worker")
        ->type_name("INT")
        ->default_str("all cores");
    app.add_option("--worker-nice", options.worker_nice, "added to the workers' niceness, 0 to 19")
        ->type_name("INT")
        ->check(CLI::Range(0, 19).description(""))
        ->capture_default_str();
    app.add_option("--save-seconds", options.save_seconds,
                   "seconds between two savings of a running job's film, from which it goes on when its worker is "
                   "lost; 0: never")
        ->type_name("SECONDS")
        ->check(CLI::NonNegativeNumber.description(""))
        ->capture_default_str();
    app.add_option("--repeats", options.repeats,
                   "times a comparison's job is repeated at most that lost processor time to other processes, 0 to 10")
        ->type_name("INT")
        ->check(CLI::Range(0, 10).description(""))
        ->capture_default_str();
    app.add_option("--tokens", options.token_file, "file of bearer tokens, NAME ROLE sha256:HEX a line")
        ->type_name("FILE")
        ->default_str("none: whoever reaches the address may do everything");
    app.add_flag("--check", check,
                 "with no daemon running: lists what is wrong with the data folder, changes nothing, and ends, with "
                 "status 2 where something is");
    app.add_flag("--repair", repair,
                 "with no daemon running: takes films that no row knows, quarantines what cannot be told, marks jobs "
                 "whose files are gone as result_lost, and ends")
        ->excludes("--check");
    app.add_option("--log-level", log_level, "how much is logged")
        ->type_name("debug|info|warning|error")
        ->capture_default_str();
    app.add_option("--new-token", new_token,
                   "NAME:read or NAME:write; prints a token and its line for the file, and ends")
        ->type_name("NAME:ROLE");
    add_limits(app, options.limits);
    CLI11_PARSE(app, argc, argv);
    spdlog::set_level(spdlog::level::from_str(log_level));

    try {
        if (!new_token.empty()) {
            const size_t colon = new_token.rfind(':');
            const std::string role = colon == std::string::npos ? "" : new_token.substr(colon + 1);
            if (colon == 0 || (role != "read" && role != "write"))
                throw Error(ErrorCode::OutOfRange, "--new-token " + new_token + " is not NAME:read or NAME:write");
            const NewToken made = make_token(new_token.substr(0, colon), role == "write" ? Role::Write : Role::Read);
            std::printf("token: %s\nline:  %s\n", made.token.c_str(), made.line.c_str());
            return EXIT_SUCCESS;
        }
        if (check) {
            const std::vector<std::string> faults = check_data_folder(options.data_dir);
            for (const std::string& line : faults) std::printf("%s\n", line.c_str());
            return faults.empty() ? EXIT_SUCCESS : kFaultsFound;
        }
        if (repair) {
            for (const std::string& line : repair_data_folder(options.data_dir)) std::printf("%s\n", line.c_str());
            return EXIT_SUCCESS;
        }
        parse_listen(listen, options);
        complete(options);
        // Before the data folder is touched: a second daemon on a port that is taken must change nothing there.
        http::Listener listener(options.listen_address, options.listen_port);
        make_data_folder(options);
        return serve(options, std::move(listener), signals);
    } catch (const std::exception& error) {
        spdlog::critical("{}", error.what());
        return EXIT_FAILURE;
    }
}
