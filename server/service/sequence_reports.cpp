#include "server/service/sequence_reports.h"

#include "renderer/core/sha256.h"
#include "server/comparisons/report_html.h"
#include "server/comparisons/sequence_html.h"
#include "server/try_later.h"

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
    const json& of_page = report.sequences.front().sequence;
    const std::string key = sequence_key(of_page, "html", state);
    const char* const media_type = "text/html; charset=utf-8";
    if (auto kept = artefact_files_.kept(key, media_type)) return *std::move(kept);
    bool lasting = true;
    for (ReportedSequence& one : report.sequences) {
        const auto of = one.sequence.at("id").get<std::string>();
        try {
            one.sheet = bytes_of(files_.video(of, {.format = "png"}));
        } catch (const Error& error) {  // a page without one picture is better than none
            lasting = lasting && !may_pass(error.code);
            report.notes.push_back("No pictures of " + of + ": " + error.what());
        }
    }
    const std::string page = sequence_html(report);
    // A page that lacks pictures for the moment goes by what it says: the next look has it made again.
    const std::string named = lasting ? key : sequence_key(of_page, "html-for-the-moment", page);
    return artefact_files_.artefact(named, media_type, [&](const std::filesystem::path& path) {
        write_text(path, page);
        return std::map<std::string, std::string>{{"Content-Security-Policy", report_content_security_policy(page)}};
    });
}

}  // namespace photond
