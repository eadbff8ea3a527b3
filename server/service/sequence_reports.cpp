#include "server/service/sequence_reports.h"

#include "renderer/core/sha256.h"
#include "server/comparisons/report_html.h"
#include "server/comparisons/sequence_html.h"

namespace photond {

using nlohmann::json;

Artefact SequenceReports::html(const std::string& id, const SequenceReportWanted& wanted) {
    if (wanted.beside.size() > kMostBeside)
        throw Error(ErrorCode::OutOfRange, "/beside",
                    "beside names " + std::to_string(wanted.beside.size()) + " sequences, a page has room for " +
                        std::to_string(kMostBeside));
    std::vector<std::string> ids = {id};
    ids.insert(ids.end(), wanted.beside.begin(), wanted.beside.end());
    const bool measured = !wanted.first.empty() || !wanted.second.empty();
    SequenceReport report;
    report.version = PHOTOND_VERSION;
    std::string state;  // all that the page shows follows from it
    for (const std::string& one : ids) {
        ReportedSequence& reported = report.sequences.emplace_back();
        reported.sequence = sequences_.get_sequence(one);
        if (measured) reported.errors = errors_.errors(one, wanted.first, wanted.second, wanted.layer);
        state += reported.sequence.dump(-1, ' ', false, json::error_handler_t::replace) + reported.errors.dump();
    }
    const std::string key = sequence_key(report.sequences.front().sequence, "html", state);
    return artefact_files_.artefact(key, "text/html; charset=utf-8", [&](const std::filesystem::path& path) {
        for (ReportedSequence& one : report.sequences) {
            const auto of = one.sequence.at("id").get<std::string>();
            try {
                one.sheet = bytes_of(files_.video(of, {.format = "png"}));
            } catch (const Error& error) {  // a page without one picture is better than none
                report.notes.push_back("No pictures of " + of + ": " + error.what());
            }
        }
        const std::string page = sequence_html(report);
        write_text(path, page);
        return std::map<std::string, std::string>{{"Content-Security-Policy", report_content_security_policy(page)}};
    });
}

}  // namespace photond
