// photonctl hard-cases

#include <chrono>
#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/hard_cases_html.h"
#include "clients/cli/output_file.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

// The short form: enough to see NaN, infinity, negative radiance, crashes and hangs in every cell, and a bias of tens
// of percent.
constexpr double kShortEffort = 1.0 / 16;
constexpr uint64_t kShortSeeds = 6;
constexpr uint64_t kShortPhotons = 10'000;
constexpr double kShortJobSeconds = 20;

struct HardCasesOptions {
    std::vector<std::string> cases;
    EntryOptions entries;
    std::optional<uint64_t> seeds;
    std::optional<double> effort, job_seconds;
    double timeout_seconds = 60;
    bool short_form = false, strict = false, list = false, keep_jobs = false;
    std::vector<std::string> pages;
    std::string json_report;
};

void check(const HardCasesOptions& options) {
    for (const std::string& page : options.pages)
        if (!page.ends_with(".html") && !page.ends_with(".htm"))
            throw Failure(ExitCode::Usage, "cannot tell what to save as " + page,
                          "name it .html (the report), or use --json-report");
    for (const std::string& page : options.pages) OutputFile::check_place(page);
    if (!options.json_report.empty()) OutputFile::check_place(options.json_report);
}

TableOptions table_options(const HardCasesOptions& options) {
    const bool is_short = options.short_form;
    TableOptions table;
    table.effort = options.effort.value_or(is_short ? kShortEffort : 1);
    table.small_images = is_short;
    table.limits.seeds = options.seeds.value_or(is_short ? kShortSeeds : RenderLimits{}.seeds);
    table.limits.job_seconds = options.job_seconds.value_or(is_short ? kShortJobSeconds : RenderLimits{}.job_seconds);
    table.limits.timeout_seconds = options.timeout_seconds;
    return table;
}

ExitCode list_cases(Session& session, const std::vector<HardCase>& cases) {
    TextTable table({{"CASE"}, {"ROW"}, {"CHECKS", Align::Right}, {"ANSWER"}});
    for (const HardCase& one : cases) {
        if (session.json_output)
            session.print_json({{"case", one.row},
                                {"name", one.name()},
                                {"scene", one.scene.empty() ? json() : json(one.scene)},
                                {"test", one.test.empty() ? json() : json(one.test)},
                                {"strains", one.strains},
                                {"text", one.text}});
        table.add_row({printable(one.name()), printable(one.row),
                       one.scene.empty() ? "-" : std::to_string(one.checks.size()),
                       one.test.empty() ? printable(one.text) : "the test " + printable(one.test)});
    }
    if (!session.json_output) table.print(std::cout);
    return ExitCode::Ok;
}

void write_file(const Session& session, const std::string& file, const std::string& text) {
    OutputFile output(file);
    output.write(text);
    output.publish();
    if (file != "-") session.remark("saved " + file + " (" + human_bytes(static_cast<double>(text.size())) + ")");
}

void save_reports(const Session& session, const HardCasesOptions& options, const HardCasesTable& table,
                  const ReportOrigin& origin) {
    for (const std::string& page : options.pages) write_file(session, page, hard_cases_html(table, origin));
    if (!options.json_report.empty())
        write_file(session, options.json_report,
                   hard_cases_json(table, origin).dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

ExitCode hard_cases(Session& session, const HardCasesOptions& given) {
    check(given);
    HardCasesOptions options = given;
    if (options.short_form && !options.entries.photons) options.entries.photons = kShortPhotons;
    std::vector<HardCase> cases = chosen_cases(hard_cases_of(session.daemon()), options.cases);
    if (options.list) return list_cases(session, cases);
    if (cases.empty()) throw Failure(ExitCode::Usage, "the daemon has no hard case", "is it of this version?");

    const auto start = std::chrono::steady_clock::now();
    const HardCasesTable table =
        measure_table(session, std::move(cases),
                      entries_from(MethodCatalogue(session.daemon(), options.entries.device), options.entries),
                      table_options(options), options.keep_jobs);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const ReportOrigin origin{plain_text(session.daemon().get("/v1/status").value("version", json())),
                              options.short_form ? "short" : "full", took.count()};
    save_reports(session, options, table, origin);
    if (session.json_output)
        session.print_json(hard_cases_json(table, origin));
    else
        print_hard_cases(std::cout, table);
    const HardCasesTable::Summary summary = table.summary();
    const bool failed = summary.defects > 0 || (options.strict && summary.breaks > 0);
    return failed ? ExitCode::JobFailed : ExitCode::Ok;
}

void add_entry_options(CLI::App& command, EntryOptions& entries) {
    command.add_option("-m,--method", entries.methods, "only this one of the daemon's methods; may be repeated")
        ->type_name("METHOD")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command
        .add_option("--entry", entries.entries,
                    "one more column: 'small splats=photon_splatting,splat_size=0.02'; may be repeated")
        ->type_name(kEntryKind)
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command.add_flag("--entries-only", entries.entries_only, "no columns but those of --entry");
    command
        .add_option("--device", entries.device,
                    "where to render; of the daemon's methods those that run there; default: cpu")
        ->type_name("DEVICE");
    command
        .add_option("--photons", entries.photons,
                    "a pass, for methods that have them; default: the method's own, 10000 with --short")
        ->type_name("INT")
        ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000'000}).description(""));
}

void add_effort_options(CLI::App& command, HardCasesOptions& options) {
    command.add_flag("--short", options.short_form, "few passes and seeds, small images: minutes instead of hours");
    command.add_option("--seeds", options.seeds, "jobs of each rendering, for its error; default: 8, 6 with --short")
        ->type_name("INT")
        ->check(CLI::Range(2, 1000).description(""));
    command
        .add_option("--effort", options.effort,
                    "factor on the passes each case suggests; default: 1, 1/16 with --short")
        ->type_name("NUMBER")
        ->check(CLI::Range(1e-6, 1e6).description(""));
    command
        .add_option("--job-seconds", options.job_seconds,
                    "a job ends after rendering this long, whatever its passes; default: 120, 20 with --short")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.001, 1e6).description(""));
    command
        .add_option("--timeout", options.timeout_seconds,
                    "a job that runs this much longer than it may render hangs; default: 60")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.001, 1e6).description(""));
}

}  // namespace

void add_hard_cases_command(CLI::App& program, Session& session) {
    CLI::App* command = program.add_subcommand(
        "hard-cases", "Every method on every hard case: bias against the known answer, NaN and infinity, verdict");
    const auto options = std::make_shared<HardCasesOptions>();
    command->add_option("case", options->cases, "only these: a scene's name, or part of a row's; default: all")
        ->type_name("CASE");
    add_entry_options(*command, options->entries);
    add_effort_options(*command, *options);
    command->add_flag("--list", options->list, "list the cases and render nothing");
    command->add_flag("--strict", options->strict, "exit code 1 also for cells that break by their figure alone");
    command->add_flag("--keep-jobs", options->keep_jobs, "leave all jobs; default: those of cells that break");
    command->add_option("-o,--output", options->pages, "save the table as a page that stands alone (.html)")
        ->type_name("FILE")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command->add_option("--json-report", options->json_report, "save the table as JSON ('-': standard output)")
        ->type_name("FILE");
    command->callback(
        [&session, options] { session.action = [&session, options] { return hard_cases(session, *options); }; });
}

}  // namespace photond::cli
