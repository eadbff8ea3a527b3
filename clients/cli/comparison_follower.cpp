#include "clients/cli/comparison_follower.h"

#include <chrono>
#include <iostream>
#include <sstream>

#include "clients/cli/compare_memory.h"
#include "clients/cli/comparison_view.h"
#include "clients/cli/job_follower.h"
#include "clients/cli/output_file.h"
#include "clients/cli/progress_view.h"
#include "clients/cli/reference_option.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr std::chrono::milliseconds kPollComparisonEvery{300};

/// Asks again and again; of its jobs, and of the reference they wait for, only the one that runs.
class ComparisonFollower {
public:
    using Listener = std::function<void(const json& comparison, const ComparisonProgress& progress)>;

    ComparisonFollower(DaemonClient& daemon, const std::string& id)
        : daemon_(daemon), path_(resource_path("comparisons", id)) {}

    json run(const Listener& listener) {
        while (true) {
            json comparison = daemon_.get(path_);
            listener(comparison, progress_of(comparison));
            if (is_over(comparison)) return comparison;
            if (!daemon_.interrupt().sleep(kPollComparisonEvery)) throw interrupted(daemon_.interrupt().cause());
        }
    }

private:
    ComparisonProgress progress_of(const json& comparison) {
        ComparisonProgress progress;
        const json jobs = comparison.value("jobs", json::array());
        progress.all = jobs.size();
        const json* next = nullptr;  // the one that runs, else the first that waits
        const auto look_at = [&](const json& job, const json& run) {
            if (is_over(run) || (next != nullptr && run.value("state", "") != "running")) return;
            next = &job;
            progress.job = run;
        };
        for (const json& job : jobs) {
            const json* last = job["runs"].empty() ? &job : &job["runs"].back();
            progress.done += is_over(*last);
            look_at(job, *last);
        }
        if (next == nullptr) return progress;
        const json reference = comparison.value("reference", json());
        if (reference.is_object() && reference.value("state", json()) == "running") {
            progress.name = "the reference";
            progress.job = daemon_.get(resource_path("jobs", reference.at("job").get<std::string>()));
        } else {
            progress.name = comparison_row_name(*next) + ", seed " + plain_text(next->value("seed", json()));
            if (next->at("id") != progress.job.at("id")) progress.name += " once more";
            progress.job = daemon_.get(resource_path("jobs", progress.job.at("id").get<std::string>()));
        }
        return progress;
    }

    DaemonClient& daemon_;
    std::string path_;
};

json follow(Session& session, const std::string& id, const ComparisonFollower::Listener& listener) {
    return ComparisonFollower(session.daemon(), id).run(listener);
}

}  // namespace

void ReportOutputs::check() const {
    for (const std::string& page : html)
        if (!page.ends_with(".html") && !page.ends_with(".htm"))
            throw Failure(ExitCode::Usage, "cannot tell what to save as " + page,
                          "name it .html (the report), or use --csv or --json-report");
    for (const std::string& page : html) OutputFile::check_place(page);
    for (const std::string& file : {csv, json})
        if (!file.empty()) OutputFile::check_place(file);
}

void add_report_options(CLI::App& command, ReportOutputs& outputs) {
    command
        .add_option("-o,--output", outputs.html,
                    "save the report (.html): plot, tables and images in one file that stands alone")
        ->type_name("FILE")
        ->expected(1)
        ->take_all();
    command.add_option("--csv", outputs.csv, "save every curve as CSV ('-': standard output)")->type_name("FILE");
    command.add_option("--json-report", outputs.json, "save tables and curves as JSON ('-': standard output)")
        ->type_name("FILE");
}

void save_reports(Session& session, const std::string& id, const ReportOutputs& outputs) {
    const std::string comparison = resource_path("comparisons", id);
    for (const std::string& page : outputs.html) save_resource(session, comparison + "/report.html", page);
    if (!outputs.csv.empty()) save_resource(session, comparison + "/report.csv", outputs.csv);
    if (!outputs.json.empty()) save_resource(session, comparison + "/report.json", outputs.json);
}

json wait_for_comparison(Session& session, const std::string& id, const WaitOptions& options, bool print_changes) {
    const std::optional<json> comparison = wait_for(session, "comparison", id, options, [&] {
        ComparisonProgressView view(session.error_is_terminal());
        json last;
        return follow(session, id, [&](const json& now, const ComparisonProgress& progress) {
            view.show(now, progress);
            if (print_changes && !is_over(now) && now != last) session.print_json(now);
            last = now;
        });
    });
    return comparison ? *comparison : follow(session, id, [](const json&, const ComparisonProgress&) {});
}

ExitCode finish_comparison(Session& session, const std::string& id, const WaitOptions& wait,
                           const ReportOutputs& outputs, bool print_changes) {
    outputs.check();
    const json comparison = wait_for_comparison(session, id, wait, print_changes);
    remark_failure(session, comparison);
    if (comparison.value("state", "") == "succeeded") save_reports(session, id, outputs);
    if (session.json_output)
        session.print_json(comparison);
    else
        print_comparison(session, comparison);
    return exit_code_of(comparison);
}

void print_comparison(Session& session, const json& comparison) {
    const std::string state = plain_text(comparison.value("state", json()));
    const json request = comparison.value("request", json::object());
    const json image = request.value("image", json::object());
    std::cout << session.bold(plain_text(comparison.value("id", json()))) << ' ' << session.coloured_state(state, state)
              << (request.value("title", json()).is_string() ? "  " + plain_text(request["title"]) : "") << '\n';
    TextTable table({{""}, {""}});
    std::istringstream notes(request.value("notes", json()).is_string() ? request["notes"].get<std::string>() : "");
    for (std::string line, label = "notes"; std::getline(notes, line); label.clear())
        table.add_row({label, printable(line)});
    table.add_row({"scene", plain_text(request.value("scene", json())) + ", " +
                                plain_text(image.value("width", json())) + " x " +
                                plain_text(image.value("height", json()))});
    table.add_row({"reference", reference_text(request.value("reference", json()))});
    table.add_row({"each job", stop_text(request.value("stop", json()))});
    const json overhead = comparison.value("overhead_seconds", json());
    if (overhead.is_number()) table.add_row({"beside their clocks", human_seconds(overhead.get<double>())});
    table.print(std::cout, "  ");
    print_comparison_tables(std::cout, comparison);
    print_disturbances(std::cout, comparison);
    print_verdicts(std::cout, comparison);
    print_structures(std::cout, structures_of(statistics_of_rows(session.daemon(), comparison)));
}

}  // namespace photond::cli
