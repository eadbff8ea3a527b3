#include "clients/cli/comparison_follower.h"

#include <chrono>
#include <iostream>

#include "clients/cli/comparison_view.h"
#include "clients/cli/job_follower.h"
#include "clients/cli/progress_view.h"
#include "clients/cli/reference_option.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr std::chrono::milliseconds kPollEvery{300};

/// Asks again and again. Jobs of a comparison run in their order, so that one of them is asked for at a time.
class ComparisonFollower {
public:
    using Listener = std::function<void(const json& comparison, const ComparisonProgress& progress)>;

    ComparisonFollower(DaemonClient& daemon, const std::string& id)
        : daemon_(daemon), path_(resource_path("comparisons", id)) {}

    json run(const Listener& listener) {
        while (true) {
            const json comparison = daemon_.get(path_);
            listener(comparison, progress_of(comparison));
            if (is_over(comparison)) return comparison;
            if (!daemon_.interrupt().sleep(kPollEvery)) throw interrupted(daemon_.interrupt().cause());
        }
    }

private:
    ComparisonProgress progress_of(const json& comparison) {
        ComparisonProgress progress;
        const json jobs = comparison.value("jobs", json::array());
        progress.all = jobs.size();
        for (; done_ < jobs.size() && jobs[done_].value("id", json()).is_string(); ++done_) {
            const json job = daemon_.get(resource_path("jobs", jobs[done_]["id"].get<std::string>()));
            if (is_over(job)) continue;
            progress.job = job;
            progress.name =
                comparison_row_name(jobs[done_]) + ", seed " + plain_text(jobs[done_].value("seed", json()));
            break;
        }
        progress.done = done_;
        return progress;
    }

    DaemonClient& daemon_;
    std::string path_;
    size_t done_ = 0;
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

void print_comparison(const Session& session, const json& comparison) {
    const std::string state = plain_text(comparison.value("state", json()));
    const json request = comparison.value("request", json::object());
    const json image = request.value("image", json::object());
    std::cout << session.bold(plain_text(comparison.value("id", json()))) << ' ' << session.coloured_state(state, state)
              << '\n';
    TextTable table({{""}, {""}});
    table.add_row({"scene", plain_text(request.value("scene", json())) + ", " +
                                plain_text(image.value("width", json())) + " x " +
                                plain_text(image.value("height", json()))});
    table.add_row({"reference", reference_text(request.value("reference", json()))});
    table.add_row({"each job", stop_text(request.value("stop", json()))});
    table.print(std::cout, "  ");
    print_comparison_tables(std::cout, comparison);
    const std::vector<std::string> sentences = verdicts(comparison);
    if (!sentences.empty()) std::cout << '\n';
    for (const std::string& sentence : sentences) std::cout << sentence << '\n';
}

}  // namespace photond::cli
