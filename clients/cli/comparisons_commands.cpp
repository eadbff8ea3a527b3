// photonctl comparisons list|show|watch|cancel|remove|fetch

#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/comparison_follower.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

struct ComparisonsOptions {
    std::vector<std::string> ids;
    size_t limit = 50;
    bool purge = false;
    WaitOptions wait;
    ReportOutputs outputs;
};

std::string labels_of(const json& request) {
    std::string labels;
    for (const json& entry : request.value("entries", json::array()))
        labels += (labels.empty() ? "" : ", ") + plain_text(entry.value("label", json()));
    return labels;
}

/// "3/6": of its jobs those that are over.
std::string jobs_of(const json& comparison) {
    uint64_t over = 0, all = 0;
    const json states = comparison.value("job_states", json::object());
    for (const auto& [state, count] : states.items()) {
        all += count.get<uint64_t>();
        if (state == "succeeded" || state == "failed" || state == "cancelled") over += count.get<uint64_t>();
    }
    return std::to_string(over) + "/" + std::to_string(all);
}

ExitCode list_comparisons(Session& session, const ComparisonsOptions& options) {
    TextTable table({{"COMPARISON"},
                     {"STATE"},
                     {"SCENE"},
                     {"SIZE", Align::Right},
                     {"JOBS", Align::Right},
                     {"ENTRIES"},
                     {"CREATED (UTC)"}});
    for (const json& comparison : session.daemon().list("/v1/comparisons", options.limit)) {
        if (session.json_output) {
            session.print_json(comparison);
            continue;
        }
        const json request = comparison.value("request", json::object());
        const json image = request.value("image", json::object());
        table.add_row({plain_text(comparison.value("id", json())), plain_text(comparison.value("state", json())),
                       plain_text(request.value("scene", json())),
                       plain_text(image.value("width", json())) + "x" + plain_text(image.value("height", json())),
                       jobs_of(comparison), labels_of(request), human_time(comparison.value("created", json()))});
    }
    if (!session.json_output) table.print(std::cout);
    return ExitCode::Ok;
}

ExitCode show_comparisons(Session& session, const ComparisonsOptions& options) {
    for (const std::string& id : options.ids) {
        const json comparison = session.daemon().get(resource_path("comparisons", id));
        if (session.json_output)
            session.print_json(comparison);
        else
            print_comparison(session, comparison);
        remark_failure(session, comparison);
    }
    return ExitCode::Ok;
}

ExitCode watch_comparison(Session& session, const ComparisonsOptions& options) {
    return finish_comparison(session, options.ids.front(), options.wait, {}, session.json_output);
}

ExitCode cancel_comparisons(Session& session, const ComparisonsOptions& options) {
    return cancel_all(session, "comparisons", options.ids, options.purge, "what its jobs rendered stays");
}

ExitCode remove_comparisons(Session& session, const ComparisonsOptions& options) {
    return cancel_all(session, "comparisons", options.ids, true, "");
}

ExitCode fetch_comparison(Session& session, const ComparisonsOptions& options) {
    const std::string& id = options.ids.front();
    ReportOutputs outputs = options.outputs;
    if (!outputs.any()) outputs.html = {id + ".html"};
    outputs.check();
    save_reports(session, id, outputs);
    return ExitCode::Ok;
}

}  // namespace

void add_comparisons_commands(CLI::App& program, Session& session) {
    CLI::App* comparisons =
        program.add_subcommand("comparisons", "Comparisons: list, show, watch, cancel, remove, fetch");
    comparisons->require_subcommand(1);
    const auto options = std::make_shared<ComparisonsOptions>();

    const auto command = [&](const char* name, const char* text, int most_ids,
                             ExitCode (*run)(Session&, const ComparisonsOptions&)) {
        CLI::App* sub = comparisons->add_subcommand(name, text);
        if (most_ids != 0) {
            CLI::Option* ids =
                sub->add_option("comparison", options->ids, most_ids == 1 ? "comparison id" : "comparison ids")
                    ->required()
                    ->type_name("COMPARISON");
            if (most_ids == 1) ids->expected(1);
        }
        sub->callback(
            [&session, options, run] { session.action = [&session, options, run] { return run(session, *options); }; });
        return sub;
    };
    constexpr int kMany = -1;

    command("list", "Comparisons, newest first", 0, list_comparisons)
        ->add_option("--limit", options->limit, "at most this many")
        ->type_name("INT")
        ->capture_default_str();
    command("show", "Tables of speed against error", kMany, show_comparisons);
    add_wait_options(*command("watch", "Follow a comparison to its end", 1, watch_comparison), options->wait);
    command("cancel", "End comparisons and the jobs they still have; what was rendered stays", kMany,
            cancel_comparisons)
        ->add_flag("--purge", options->purge, "also remove the comparison, its jobs and their files");
    command("remove", "Remove comparisons with their jobs and files; one that runs is ended first", kMany,
            remove_comparisons);
    add_report_options(*command("fetch", "Save the report; default: COMPARISON.html", 1, fetch_comparison),
                       options->outputs);
}

}  // namespace photond::cli
