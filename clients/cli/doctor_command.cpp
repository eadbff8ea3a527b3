// photonctl doctor: is everything here that rendering needs?

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "clients/cli/commands.h"
#include "clients/cli/job_view.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double kLowDiskBytes = 2.0 * 1024 * 1024 * 1024;
constexpr double kSlowAnswerSeconds = 0.1;  // the daemon answers in a few milliseconds even while it renders

enum class Outcome : uint8_t { Ok, Warn, Fail };

struct Check {
    std::string name;
    Outcome outcome;
    std::string found;
    std::string fix;  // empty when ok
};

const char* outcome_word(Outcome outcome) {
    return outcome == Outcome::Ok ? "ok" : outcome == Outcome::Warn ? "warn" : "fail";
}

class Doctor {
public:
    Doctor(Session& session, bool renders) : session_(session), renders_(renders) {}

    std::vector<Check> examine() {
        const bool here = is_this_machine();
        if (here) check_programs();
        check_disk();
        if (!check_reachable()) return std::move(checks_);
        check_token();
        check_readiness();
        if (!authorised_) return std::move(checks_);
        check_status();
        check_devices();
        check_methods();
        if (renders_) check_render();
        return std::move(checks_);
    }

    bool reached() const { return reached_; }

private:
    void add(const std::string& name, Outcome outcome, const std::string& found, const std::string& fix = "") {
        checks_.push_back({name, outcome, found, fix});
    }

    /// Runs one question; a refusal or an answer of the wrong shape is a failed check, not the end.
    template <class Question>
    void guarded(const std::string& name, const std::string& fix, Question question) {
        try {
            question();
        } catch (const Failure& failure) {
            if (failure.code == ExitCode::Interrupted) throw;
            add(name, Outcome::Fail, failure.what(), failure.hint.empty() ? fix : failure.hint);
        } catch (const json::exception& error) {
            add(name, Outcome::Fail, std::string("not what the protocol says: ") + error.what(), fix);
        }
    }

    bool is_this_machine() const {
        const std::string& url = session_.server.url;
        return url.find("://127.") != std::string::npos || url.find("://localhost") != std::string::npos ||
               url.find("://[::1]") != std::string::npos;
    }

    /// What the dynamic loader says of the daemon's programs, which lie beside this one.
    void check_programs() {
        std::error_code error;
        const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
        for (const char* program : {"photond", "photond-worker"}) {
            const fs::path file = folder / program;
            if (access(file.c_str(), X_OK) != 0) {
                add(program, Outcome::Warn, "not in " + folder.string(),
                    "build it: deploy/quickstart --build-only (not needed for a daemon that is installed elsewhere)");
                continue;
            }
            const std::string libraries = output_of({"ldd", file.string()});
            std::string missing;
            size_t found = 0;
            std::istringstream lines(libraries);
            for (std::string line; std::getline(lines, line);) {
                const size_t arrow = line.find("=>");
                if (arrow == std::string::npos) continue;
                if (line.find("not found") == std::string::npos) {
                    ++found;
                    continue;
                }
                const std::string name = line.substr(0, arrow);
                const size_t begin = name.find_first_not_of(" \t");
                missing += (missing.empty() ? "" : ", ") + name.substr(begin, name.find_last_not_of(' ') + 1 - begin);
            }
            if (!missing.empty())
                add(program, Outcome::Fail, "libraries missing: " + missing,
                    "install them: deploy/quickstart --build-only");
            else if (found == 0)
                add(program, Outcome::Warn, "its libraries could not be listed (ldd)");
            else
                add(program, Outcome::Ok, "all " + std::to_string(found) + " libraries found");
        }
    }

    static std::string output_of(std::vector<std::string> arguments) {
        std::array<int, 2> pipe_ends{};
        if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) return "";
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
        std::vector<char*> argv;
        argv.reserve(arguments.size() + 1);
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        pid_t child = 0;
        const int failed = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        close(pipe_ends[1]);
        std::string output;
        std::array<char, 4096> buffer{};
        while (!failed) {
            const ssize_t count = read(pipe_ends[0], buffer.data(), buffer.size());
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) break;
            output.append(buffer.data(), static_cast<size_t>(count));
        }
        close(pipe_ends[0]);
        if (!failed) waitpid(child, nullptr, 0);
        return output;
    }

    void check_disk() {
        std::error_code error;
        const fs::space_info space = fs::space(".", error);
        if (error)
            return add("disk here", Outcome::Fail, error.message(),
                       "images are saved in the current folder: change to another");
        const auto available = static_cast<double>(space.available);
        if (access(".", W_OK) != 0)
            add("disk here", Outcome::Warn, "the current folder cannot be written to", "give -o a path elsewhere");
        else
            add("disk here", available < kLowDiskBytes ? Outcome::Warn : Outcome::Ok, human_bytes(available) + " free",
                available < kLowDiskBytes ? "images are saved here: free some space" : "");
    }

    bool check_reachable() {
        std::vector<double> spans;
        try {
            HttpRequest request;
            request.path = "/healthz";
            for (int i = 0; i < 5; ++i) {
                const auto begun = Clock::now();
                session_.daemon().ask(request, Repeat::Safely);
                spans.push_back(std::chrono::duration<double>(Clock::now() - begun).count());
            }
        } catch (const Failure& failure) {
            if (failure.code == ExitCode::Interrupted) throw;
            reached_ = failure.code == ExitCode::Refused;
            add("daemon", Outcome::Fail, failure.what(), failure.hint);
            return false;
        }
        reached_ = true;
        std::nth_element(spans.begin(), spans.begin() + 2, spans.end());
        const bool slow = spans[2] > kSlowAnswerSeconds;
        add("daemon", slow ? Outcome::Warn : Outcome::Ok,
            session_.server.url + " answers in " + human_seconds(spans[2]) + " (median of 5)",
            slow ? "the network, or a machine short of memory or processor time, is in the way" : "");
        return true;
    }

    void check_token() {
        try {
            session_.daemon().get("/v1/status");
            authorised_ = true;
            add("access", Outcome::Ok, session_.server.token.empty() ? "no token needed" : "the token is accepted");
        } catch (const Failure& failure) {
            if (failure.code == ExitCode::Interrupted) throw;
            add("access", Outcome::Fail, failure.what(),
                "set PHOTOND_TOKEN or --token-file to a token of the daemon's --tokens file");
        }
    }

    void check_readiness() {
        guarded("ready", "wait, then look into the daemon's log: a worker or the store does not come up", [&] {
            HttpRequest request;
            request.path = "/readyz";
            session_.daemon().ask(request, Repeat::Safely);
            add("ready", Outcome::Ok, "store open, every worker answered");
        });
    }

    void check_status() {
        guarded("version", "install the same version on both sides", [&] {
            const json status = session_.daemon().get("/v1/status");
            const std::string version = status.at("version").get<std::string>();
            const bool same = version == PHOTOND_VERSION;
            add("version", same ? Outcome::Ok : Outcome::Warn,
                same ? "both " + version : "daemon " + printable(version) + ", photonctl " PHOTOND_VERSION,
                same ? "" : "install the same version on both sides");
            check_daemon_disk(status);
            check_sandbox(status);
        });
    }

    /// What keeps a worker that a scene has taken over from files that are not its own: the least of all processes.
    void check_sandbox(const json& status) {
        json least;
        const auto rank = [](const json& access) {
            const std::string by = access.at("by").get<std::string>();
            return by == "landlock" ? 2 : by == "mount_namespace" ? 1 : 0;
        };
        for (const json& process : processes_of(status)) {
            const json access = process.value("file_access", json());
            if (access.is_object() && (least.is_null() || rank(access) < rank(least))) least = access;
        }
        if (least.is_null()) return;  // an older daemon, or one whose processes have not said a word yet
        if (rank(least) == 2)
            add("sandbox", Outcome::Ok,
                "the workers' files are bounded by Landlock, version " + plain_text(least.at("version")));
        else if (rank(least) == 1)
            add("sandbox", Outcome::Ok, "the workers' files are bounded by a mount namespace");
        else
            add("sandbox", Outcome::Warn, "none: workers may open any file of the daemon's user",
                "use a kernel with Landlock (CONFIG_SECURITY_LANDLOCK, and landlock in lsm=) or allow user namespaces");
    }

    static std::vector<json> processes_of(const json& status) {
        std::vector<json> all;
        for (const char* list : {"workers", "helpers"})
            for (const json& process : status.value(list, json::array())) all.push_back(process);
        if (status.contains("pictures")) all.push_back(status["pictures"]);
        return all;
    }

    /// The daemon's own figure, where it gives one: its data folder may lie on another disk or machine.
    void check_daemon_disk(const json& status) {
        json free = status.value("disk_free_bytes", json());
        if (status.contains("disk") && status["disk"].is_object()) free = status["disk"].value("free_bytes", json());
        if (!free.is_number()) return;
        const bool low = free.get<double>() < kLowDiskBytes;
        add("daemon's disk", low ? Outcome::Warn : Outcome::Ok, human_bytes(free.get<double>()) + " free",
            low ? "free some space: remove old jobs (photonctl jobs cancel --purge) and scenes" : "");
    }

    void check_devices() {
        guarded("devices", "see the daemon's log", [&] {
            const json devices = session_.daemon().get("/v1/devices").at("items");
            if (devices.empty()) add("devices", Outcome::Fail, "none", "start the daemon with --devices cpu");
            for (const json& device : devices) {
                if (!device.value("served", true)) continue;
                const std::string state = device.at("state").get<std::string>();
                const bool failed = state == "failed";
                add("device " + plain_text(device.at("id")), failed ? Outcome::Fail : Outcome::Ok,
                    plain_text(device.value("name", json())) + ", " + printable(state),
                    failed ? "its worker does not stay up: see the daemon's log" : "");
            }
        });
    }

    void check_methods() {
        guarded("methods", "install the daemon anew", [&] {
            std::string names;
            const json methods = session_.daemon().get("/v1/methods").at("items");
            for (const json& method : methods) names += (names.empty() ? "" : ", ") + plain_text(method.at("name"));
            add("methods", names.empty() ? Outcome::Fail : Outcome::Ok, names.empty() ? "none" : names,
                names.empty() ? "install the daemon anew" : "");
        });
    }

    static json small_job() {
        return {{"scene", "cornell-box"},
                {"image", {{"width", 64}, {"height", 64}}},
                {"method", {{"name", kDefaultMethod}}},
                {"stop", {{"passes", 1}}},
                {"labels", {{"photonctl", "doctor"}}}};
    }

    void check_render() {
        guarded("render", "photonctl jobs list --label photonctl=doctor shows it", [&] {
            const auto begun = Clock::now();
            const json accepted = session_.daemon().send("POST", "/v1/jobs", small_job(), Repeat::OnlyIfRefused);
            const std::string id = accepted.at("id").get<std::string>();
            const json job = wait_for_job(session_, id, {}, false);
            if (exit_code_of(job) != ExitCode::Ok) {
                remark_failure(session_, job);
                return add("render", Outcome::Fail, id + " " + plain_text(job.value("state", json())),
                           "photonctl jobs show " + id);
            }
            HttpRequest image;
            image.path = resource_path("jobs", id) + "/image.exr";
            const HttpReply exr = session_.daemon().ask(image, Repeat::Safely);
            // OpenEXR's magic number: a file that is none would be a defect of the service.
            const bool is_exr = exr.status == 200 && exr.body.starts_with("\x76\x2f\x31\x01");
            add("render", is_exr ? Outcome::Ok : Outcome::Fail,
                is_exr
                    ? "a 64 x 64 image in " +
                          human_seconds(std::chrono::duration<double>(Clock::now() - begun).count()) + ", start to EXR"
                    : "the image of " + id + " is no EXR",
                is_exr ? "" : "see the daemon's log");
        });
    }

    Session& session_;
    bool renders_;
    bool reached_ = false;
    bool authorised_ = false;
    std::vector<Check> checks_;
};

ExitCode run_doctor(Session& session, bool renders) {
    session.server.retry_seconds = std::min(session.server.retry_seconds, 2.0);
    Doctor doctor(session, renders);
    const std::vector<Check> checks = doctor.examine();
    bool failed = false;
    size_t name_columns = 0;
    for (const Check& check : checks) name_columns = std::max(name_columns, display_width(check.name));
    for (const Check& check : checks) {
        failed = failed || check.outcome == Outcome::Fail;
        const std::string word = outcome_word(check.outcome);
        if (session.json_output) {
            session.print_json({{"check", check.name},
                                {"state", word},
                                {"found", check.found},
                                {"fix", check.fix.empty() ? json() : json(check.fix)}});
            continue;
        }
        const std::string indent(name_columns + 8, ' ');
        std::cout << session.coloured_state(word, word + std::string(6 - word.size(), ' ')) << check.name
                  << std::string(name_columns - display_width(check.name) + 2, ' ') << check.found << '\n';
        if (!check.fix.empty()) std::cout << indent << "-> " << check.fix << '\n';
    }
    if (!doctor.reached()) return ExitCode::Unreachable;
    return failed ? ExitCode::JobFailed : ExitCode::Ok;
}

}  // namespace

void add_doctor_command(CLI::App& program, Session& session) {
    CLI::App* command =
        program.add_subcommand("doctor", "Is everything here? Each check with what to do when it is not");
    const auto renders = std::make_shared<bool>(false);
    command->add_flag("--render", *renders, "also render a small image from start to EXR");
    command->callback(
        [&session, renders] { session.action = [&session, renders] { return run_doctor(session, *renders); }; });
}

}  // namespace photond::cli
