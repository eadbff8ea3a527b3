// photonctl jobs list|show|watch|cancel|remove|priority|retry|repeat|extend|fetch

#include <iostream>
#include <map>

#include "clients/cli/commands.h"
#include "clients/cli/job_view.h"
#include "clients/cli/json_member.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

struct JobsOptions {
    std::vector<std::string> ids;
    std::string id;
    std::string state, label, scene, method;
    size_t limit = 50;
    int priority = 0;
    bool purge = false;
    StopOptions stop;
    WaitOptions wait;
    JobOutputs outputs;
};

std::string text_of(const json& object, const char* key) {
    return object.is_object() && object.contains(key) ? plain_text(object[key]) : "-";
}

/// What uploaded scenes are called that jobs have by their ids; a scene that is gone keeps its id. Each is asked for
/// once.
class SceneNames {
public:
    explicit SceneNames(DaemonClient& daemon) : daemon_(daemon) {}

    std::string of(const std::string& scene) {
        constexpr size_t kIdLength = 32;
        if (scene.size() != kIdLength || scene.find_first_not_of("0123456789abcdef") != std::string::npos) return scene;
        const auto [known, is_new] = names_.try_emplace(scene, scene);
        if (!is_new) return known->second;
        try {
            const std::string name = daemon_.get(resource_path("scenes", scene)).value("name", "");
            if (!name.empty()) known->second = printable(name);
        } catch (const Failure& failure) {
            if (failure.code != ExitCode::Refused) throw;
        }
        return known->second;
    }

private:
    DaemonClient& daemon_;
    std::map<std::string, std::string> names_;
};

void add_job_row(TextTable& table, const json& job, SceneNames& scenes) {
    const json request = job.value("request", json::object());
    const json image = request.value("image", json::object());
    const json method = request.value("method", json::object());
    const json progress = job.value("progress", json());
    const json seconds = job.value("seconds", json());
    table.add_row({text_of(job, "id"), text_of(job, "state"),
                   progress.is_number() ? human_number(double(int(progress.get<double>() * 100))) + " %" : "-",
                   scenes.of(text_of(request, "scene")), text_of(method, "name"),
                   text_of(image, "width") + "x" + text_of(image, "height"), text_of(job, "passes_done"),
                   seconds.is_number() ? human_seconds(seconds.get<double>()) : "-",
                   human_time(job.value("created", json()))});
}

ExitCode list_jobs(Session& session, const JobsOptions& options) {
    std::string query;
    for (const auto& [name, value] : {std::pair("state", options.state), std::pair("label", options.label),
                                      std::pair("scene", options.scene), std::pair("method", options.method)})
        if (!value.empty()) query += (query.empty() ? "?" : "&") + std::string(name) + "=" + percent_encode(value);
    TextTable table({{"JOB"},
                     {"STATE"},
                     {"DONE", Align::Right},
                     {"SCENE"},
                     {"METHOD"},
                     {"SIZE", Align::Right},
                     {"PASSES", Align::Right},
                     {"RENDERED", Align::Right},
                     {"CREATED (UTC)"}});
    SceneNames scenes(session.daemon());
    for (const json& job : session.daemon().list("/v1/jobs" + query, options.limit)) {
        if (session.json_output)
            session.print_json(job);
        else
            add_job_row(table, job, scenes);
    }
    if (!session.json_output) table.print(std::cout);
    return ExitCode::Ok;
}

ExitCode show_jobs(Session& session, const JobsOptions& options) {
    for (const std::string& id : options.ids) {
        const json job = session.daemon().get(resource_path("jobs", id));
        if (session.json_output)
            session.print_json(job);
        else
            print_job(session, job);
        remark_failure(session, job);
        remark_disturbance(session, job);
    }
    return ExitCode::Ok;
}

ExitCode watch_job(Session& session, const JobsOptions& options) {
    const json job = wait_for_job(session, options.ids.front(), options.wait, session.json_output);
    if (session.json_output)
        session.print_json(job);
    else
        print_job(session, job);
    remark_failure(session, job);
    remark_disturbance(session, job);
    return exit_code_of(job);
}

ExitCode cancel_jobs(Session& session, const JobsOptions& options) {
    return cancel_all(session, "jobs", options.ids, options.purge, "what was rendered stays");
}

ExitCode remove_jobs(Session& session, const JobsOptions& options) {
    return cancel_all(session, "jobs", options.ids, true, "");
}

ExitCode retry_jobs(Session& session, const JobsOptions& options) {
    for (const std::string& id : options.ids) {
        const json job =
            session.daemon().send("POST", resource_path("jobs", id) + "/retry", nullptr, Repeat::OnlyIfRefused);
        if (session.json_output) session.print_json(job);
        session.remark(id + " is tried again, now " + text_of(job, "state"));
    }
    return ExitCode::Ok;
}

ExitCode set_priority(Session& session, const JobsOptions& options) {
    const json job = session.daemon().send("PATCH", resource_path("jobs", options.id), {{"priority", options.priority}},
                                           Repeat::Safely);
    if (session.json_output) session.print_json(job);
    session.remark(options.id + " has priority " + text_of(member(job, "request"), "priority"));
    return ExitCode::Ok;
}

ExitCode repeat_jobs(Session& session, const JobsOptions& options) {
    for (const std::string& id : options.ids) {
        const json job =
            session.daemon().send("POST", resource_path("jobs", id) + "/repeat", nullptr, Repeat::OnlyIfRefused);
        if (session.json_output) session.print_json(job);
        const std::string repeat = text_of(job, "id");
        session.remark(id + " is repeated as " + repeat + "; watch it: photonctl jobs watch " + repeat);
    }
    return ExitCode::Ok;
}

ExitCode extend_job(Session& session, const JobsOptions& options) {
    if (!options.stop.any())
        throw Failure(ExitCode::Usage, "until when? --passes, --seconds or --target is needed",
                      "they count from the first pass: a job of 64 passes goes on with --passes 256");
    const std::string& id = options.ids.front();
    const json job = session.daemon().send("POST", resource_path("jobs", id) + "/extend",
                                           {{"stop", options.stop.body()}}, Repeat::OnlyIfRefused);
    if (session.json_output) session.print_json(job);
    session.remark(id + " goes on, now " + text_of(job, "state") + "; watch it: photonctl jobs watch " + id);
    return ExitCode::Ok;
}

ExitCode fetch_job(Session& session, const JobsOptions& options) {
    const std::string& id = options.ids.front();
    JobOutputs outputs = options.outputs;
    if (!outputs.any()) outputs.images = {id + ".exr"};
    outputs.check(session);
    const json job = session.daemon().get(resource_path("jobs", id));
    save_job_outputs(session, id, outputs);
    if (session.json_output) session.print_json(job);
    return ExitCode::Ok;
}

}  // namespace

void add_jobs_commands(CLI::App& program, Session& session) {
    CLI::App* jobs =
        program.add_subcommand("jobs", "Render jobs: list, show, watch, cancel, remove, change, repeat, fetch");
    jobs->require_subcommand(1);
    const auto options = std::make_shared<JobsOptions>();

    const auto command = [&](const char* name, const char* text, int most_ids,
                             ExitCode (*run)(Session&, const JobsOptions&)) {
        CLI::App* sub = jobs->add_subcommand(name, text);
        if (most_ids != 0) {
            CLI::Option* ids = sub->add_option("job", options->ids, most_ids == 1 ? "job id" : "job ids")
                                   ->required()
                                   ->type_name("JOB");
            if (most_ids == 1) ids->expected(1);
        }
        sub->callback(
            [&session, options, run] { session.action = [&session, options, run] { return run(session, *options); }; });
        return sub;
    };
    constexpr int kMany = -1;

    CLI::App* list = command("list", "Jobs, newest first", 0, list_jobs);
    list->add_option("--state", options->state, "only those in this state")
        ->type_name("queued|running|succeeded|failed|cancelled");
    list->add_option("--label", options->label, "only those with this label")->type_name("KEY=VALUE");
    list->add_option("--scene", options->scene, "only those of this scene")->type_name("SCENE");
    list->add_option("--method", options->method, "only those by this method")->type_name("METHOD");
    list->add_option("--limit", options->limit, "at most this many")->type_name("INT")->capture_default_str();

    command("show", "Request, state and statistics of jobs", kMany, show_jobs);
    add_wait_options(*command("watch", "Follow a job to its end", 1, watch_job), options->wait);

    command("cancel", "End jobs; what was rendered stays", kMany, cancel_jobs)
        ->add_flag("--purge", options->purge, "also remove the job and its files");
    command("remove", "Remove jobs with their films and images; one that runs is ended first", kMany, remove_jobs);
    CLI::App* priority = command("priority", "Change the priority of a job that is queued or running", 0, set_priority);
    priority->add_option("job", options->id, "job id")->required()->type_name("JOB");
    priority->add_option("priority", options->priority, "-100 to 100, higher first")->required()->type_name("INT");
    command("retry", "Queue failed or cancelled jobs again", kMany, retry_jobs);

    command("repeat", "Render jobs again as new ones; those of a comparison in their place", kMany, repeat_jobs);

    add_stop_options(*command("extend", "Go on with a finished job: more passes on the same film", 1, extend_job),
                     options->stop, "stop at this many passes, those it has counted");

    CLI::App* fetch =
        command("fetch", "Save images, errors, statistics, log or photon map of a job; default: JOB.exr", 1, fetch_job);
    add_output_options(*fetch, options->outputs);
    fetch->add_option("--statistics", options->outputs.statistics, "save statistics.json ('-': standard output)")
        ->type_name("FILE");
    fetch->add_option("--log", options->outputs.log, "save the log ('-': standard output)")->type_name("FILE");
}

}  // namespace photond::cli
