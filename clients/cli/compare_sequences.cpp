#include "clients/cli/compare_sequences.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "clients/cli/output_file.h"
#include "clients/cli/request_options.h"
#include "clients/cli/sequence_follower.h"
#include "clients/cli/text_table.h"
#include "clients/cli/transfer.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr uint64_t kReferenceSeeds[] = {10'000, 20'000};  // farther apart than there are frames

struct ComparedSequence {
    std::string label, id;
    json errors;             // as GET /v1/sequences/{id}/errors has them
    double seconds, passes;  // in the mean over frames
};

/// Names it on the page.
std::string submit_sequence(Session& session, json request, const json& entry, const json& seed) {
    for (const char* member : {"entries", "seeds", "metrics"}) request.erase(member);
    request["method"] = entry.at("method");
    request["seed"] = seed;
    request["labels"]["entry"] = entry.at("label");
    return submit(session, "/v1/sequences", request, "").at("id").get<std::string>();
}

std::vector<std::string> submit_references(Session& session, json request, const json& reference) {
    request["stop"] = {{"passes", reference.at("passes")}};
    std::vector<std::string> ids;
    for (const uint64_t seed : kReferenceSeeds)
        ids.push_back(
            submit_sequence(session, request, {{"label", "reference"}, {"method", reference.at("method")}}, seed));
    return ids;
}

/// Throws Failure(JobFailed) unless every frame is there.
json finished(Session& session, const std::string& label, const std::string& id, const WaitOptions& wait) {
    json sequence = wait_for_sequence(session, id, wait);
    if (sequence.at("state") != "succeeded")
        throw Failure(ExitCode::JobFailed,
                      "sequence " + id + " (" + printable(label) + ") " + plain_text(sequence.at("state")),
                      "photonctl sequences show " + id);
    return sequence;
}

void put_costs(Session& session, const json& sequence, ComparedSequence& compared) {
    compared.seconds = compared.passes = 0;
    const json& frames = sequence.at("frames");
    const auto count = static_cast<double>(frames.size());
    for (const json& frame : frames) {
        const json job = session.daemon().get(resource_path("jobs", frame.at("id").get<std::string>()));
        compared.seconds += frame.at("seconds").get<double>() / count;
        compared.passes += job.at("passes_done").get<double>() / count;
    }
}

/// "0.0123 ± 0.0004": half of the interval that the references' noise leaves.
std::string with_interval(const json& figure) {
    if (!figure.is_object()) return "-";
    const json& interval = figure.at("interval");
    const double half = (interval.at(1).get<double>() - interval.at(0).get<double>()) / 2;
    return three_digit_number(figure.at("value").get<double>()) + " ± " + three_digit_number(half);
}

void print_table(const std::vector<ComparedSequence>& rows) {
    TextTable table({{"ENTRY"},
                     {"SECONDS A FRAME", Align::Right},
                     {"PASSES", Align::Right},
                     {"RELATIVE_MSE"},
                     {"FLICKER"},
                     {"LAG"},
                     {"SEQUENCE"}});
    for (const ComparedSequence& row : rows) {
        const json& mean = row.errors.at("mean");
        table.add_row({printable(row.label), three_digit_number(row.seconds), three_digit_number(row.passes),
                       with_interval(mean.at("relative_mse")), with_interval(mean.at("flicker")),
                       with_interval(mean.at("lag")), row.id});
    }
    table.print(std::cout);
}

json json_report(const json& request, const std::vector<std::string>& references,
                 const std::vector<ComparedSequence>& rows) {
    json report{{"request", request}, {"references", references}, {"rows", json::array()}};
    for (const ComparedSequence& row : rows)
        report["rows"].push_back({{"label", row.label},
                                  {"sequence", row.id},
                                  {"seconds_a_frame", row.seconds},
                                  {"passes", row.passes},
                                  {"errors", row.errors}});
    return report;
}

/// Letters and digits of a label, the rest as '-'.
std::string file_name_of(std::string label) {
    std::replace_if(
        label.begin(), label.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '-');
    return label;
}

void save_videos(Session& session, const std::vector<ComparedSequence>& rows, const std::string& reference,
                 const std::string& folder) {
    std::filesystem::create_directories(folder);
    const auto save = [&](const std::string& label, const std::string& id) {
        save_resource(session, resource_path("sequences", id) + "/video?format=mp4",
                      (std::filesystem::path(folder) / (file_name_of(label) + ".mp4")).string());
    };
    save("reference", reference);
    for (const ComparedSequence& row : rows) save(row.label, row.id);
}

void save_reports(Session& session, const std::vector<ComparedSequence>& rows,
                  const std::vector<std::string>& references, const json& report, const SequenceReports& reports) {
    std::string query = "/report.html?first=" + references[0] + "&second=" + references[1];
    for (size_t i = 1; i < rows.size(); ++i) query += (i == 1 ? "&beside=" : ",") + rows[i].id;
    for (const std::string& page : reports.outputs.html)
        save_resource(session, resource_path("sequences", rows.front().id) + query, page);
    if (!reports.outputs.json.empty()) {
        OutputFile file(reports.outputs.json);
        file.write(report.dump(2) + "\n");
        file.publish();
        session.remark("saved " + reports.outputs.json);
    }
    if (!reports.videos.empty()) save_videos(session, rows, references[0], reports.videos);
}

}  // namespace

ExitCode compare_sequences(Session& session, const json& request, const json& reference, const WaitOptions& wait,
                           const SequenceReports& reports) {
    const json seeds = request.value("seeds", json::array({1}));
    if (seeds.size() != 1) throw Failure(ExitCode::Usage, "sequences are compared with one seed");
    const std::vector<std::string> references = submit_references(session, request, reference);
    std::vector<ComparedSequence> rows;
    for (const json& entry : request.at("entries"))
        rows.push_back({.label = entry.at("label").get<std::string>(),
                        .id = submit_sequence(session, request, entry, seeds.front()),
                        .errors = {},
                        .seconds = 0,
                        .passes = 0});
    for (const std::string& id : references) finished(session, "reference", id, wait);
    for (ComparedSequence& row : rows) put_costs(session, finished(session, row.label, row.id, wait), row);
    for (ComparedSequence& row : rows)
        row.errors = session.daemon().get(resource_path("sequences", row.id) + "/errors?first=" + references[0] +
                                          "&second=" + references[1]);
    const json report = json_report(request, references, rows);
    save_reports(session, rows, references, report, reports);
    if (session.json_output)
        session.print_json(report);
    else
        print_table(rows);
    return ExitCode::Ok;
}

}  // namespace photond::cli
