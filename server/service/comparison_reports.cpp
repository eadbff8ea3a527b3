#include "server/service/comparison_reports.h"

#include <algorithm>

#include "renderer/core/sha256.h"
#include "server/comparisons/exposure.h"
#include "server/comparisons/report_csv.h"
#include "server/comparisons/report_html.h"
#include "server/row_text.h"
#include "server/try_later.h"

namespace photond {

using nlohmann::json;

namespace {

std::string cache_prefix(const json& comparison, const char* what) {
    return "comparison/" + comparison.at("id").get<std::string>().substr(1) + "/" + what + "/";
}

json curve_json(const MeasuredJob& job) {
    json points = json::array();
    for (const CurvePoint& point : job.curve) {
        json metrics = json::object(), intervals = json::object();
        for (const auto& [metric, value] : point.metrics) metrics[metric] = value ? json(*value) : json();
        for (const auto& [metric, ends] : point.intervals) {
            intervals[metric] = {ends.least, ends.greatest};
            metrics.emplace(metric, nullptr);  // the root of what was estimated below 0
        }
        points.push_back({{"seconds", point.seconds},
                          {"passes", point.passes},
                          {"photons", point.photons ? json(*point.photons) : json()},
                          {"metrics", metrics},
                          {"intervals", intervals}});
    }
    return points;
}

constexpr size_t kMostRowsPictured = 24;            // three images each
constexpr uint64_t kMostPictureBytes = 20'000'000;  // of all images of a page, as PNG

/// Rows to be shown as images: those on the Pareto front first, in the end by their places.
std::vector<size_t> pictured_rows(const ComparisonTable& table, const std::vector<MeasuredJob>& jobs, Report& report) {
    std::vector<size_t> rows;
    for (const bool front : {true, false})
        for (size_t r = 0; r < table.rows.size(); ++r)
            if (table.rows[r].pareto == front && rows.size() < kMostRowsPictured) rows.push_back(r);
    std::sort(rows.begin(), rows.end());
    if (rows.size() < table.rows.size())
        report.notes.push_back("Images of " + std::to_string(rows.size()) + " of " + std::to_string(table.rows.size()) +
                               " rows are shown, those on the Pareto front first.");
    // Only what has succeeded: the film of a job under way would be another one at the next look.
    std::erase_if(rows, [&](size_t r) {
        const auto job = std::find_if(jobs.begin(), jobs.end(),
                                      [&](const MeasuredJob& any) { return any.id == table.rows[r].jobs.front(); });
        return job == jobs.end() || !job->succeeded();
    });
    return rows;
}

/// Leaves out the largest of those that matter least: maps before images, until the rest is small enough.
void bound_pictures(Report& report) {
    uint64_t total = 0;
    for (const ReportPicture& picture : report.pictures) total += picture.png.size();
    size_t left_out = 0;
    while (total > kMostPictureBytes) {
        const auto weight = [](const ReportPicture& picture) {
            return std::pair(picture.kind != ReportPicture::Kind::Beauty, picture.png.size());
        };
        const auto worst =
            std::max_element(report.pictures.begin(), report.pictures.end(),
                             [&](const ReportPicture& a, const ReportPicture& b) { return weight(a) < weight(b); });
        total -= worst->png.size();
        report.pictures.erase(worst);
        ++left_out;
    }
    if (left_out > 0)
        report.notes.push_back(std::to_string(left_out) + " images are left out, to keep this page below " +
                               std::to_string(kMostPictureBytes / 1'000'000) +
                               " MB of images; photond gives them at /v1/jobs/ID/preview.png, error.png and flip.png.");
}

}  // namespace

bool ComparisonReports::add_pictures(Report& report, const Judged& judged) {
    const json& comparison = judged.object;
    const std::vector<size_t> rows = pictured_rows(judged.table, judged.jobs, report);
    if (rows.empty()) return true;
    bool lasting = true;
    const json reference = comparison.at("reference");
    const bool reference_rendered = reference.is_object() && reference["job"].is_string() &&
                                    reference["state"] == job_state_name(JobState::Succeeded);
    const auto add = [&report, &lasting](ReportPicture::Kind kind, const std::string& name, const std::string& job,
                                         const std::function<Artefact()>& encode) {
        try {
            const Artefact artefact = encode();
            if (!artefact.pending) report.pictures.push_back({kind, name, job, bytes_of(artefact)});
        } catch (const Error& error) {  // a page without one image is better than none
            const bool passes = may_pass(error.code);
            lasting = lasting && !passes;
            report.notes.push_back("No image of " + name + " (" + job + "): " + error.what() +
                                   (passes ? "; a later look at this page may have it." : ""));
        }
    };
    const auto preview = [&](const std::string& job) {
        return jobs_.artefacts.preview(job, {.exposure_stops = report.exposure_stops});
    };
    const std::string exposed_by =
        reference_rendered ? reference["job"].get<std::string>() : judged.table.rows[rows.front()].jobs.front();
    const Artefact raw = jobs_.artefacts.pixels(exposed_by, "beauty", "float");
    if (!raw.pending) report.exposure_stops = exposure_stops(raw.path);
    if (reference_rendered)
        add(ReportPicture::Kind::Beauty, "reference", exposed_by, [&] { return preview(exposed_by); });
    for (const size_t r : rows) {
        const TableRow& row = judged.table.rows[r];
        const std::string name = row_name(row.label, row.parameters), &job = row.jobs.front();
        add(ReportPicture::Kind::Beauty, name, job, [&] { return preview(job); });
        if (reference.is_null()) continue;
        add(ReportPicture::Kind::Error, name, job, [&] { return jobs_.errors.error_map(job, "beauty"); });
        add(ReportPicture::Kind::Flip, name, job, [&] { return jobs_.errors.flip(job, "beauty", "hdr"); });
    }
    bound_pictures(report);
    return lasting;
}

Artefact ComparisonReports::comparison_html(const std::string& id) {
    const Compared compared = comparisons_.read_comparison(id);
    const Judged judged = judge(compared);
    // What the page shows follows from this object and from films that do not change once their job has succeeded.
    const std::string state = judged.object.dump(-1, ' ', false, json::error_handler_t::replace);
    const std::string prefix = cache_prefix(judged.object, "html");
    const std::string key = prefix + sha256_hex(state.data(), state.size());
    const char* const media_type = "text/html; charset=utf-8";
    if (auto kept = artefact_files_.kept(key, media_type)) return *std::move(kept);
    Report report;
    report.comparison = judged.object;
    report.table = judged.table;
    report.version = PHOTOND_VERSION;
    report.statistics = judged.statistics;
    const bool lasting = add_pictures(report, judged);
    const std::string page = report_html(report);
    // A page that lacks a picture for the moment goes by what it says, so that the next look has it made again.
    const std::string of_page = prefix + "for-the-moment/" + sha256_hex(page.data(), page.size());
    return artefact_files_.artefact(lasting ? key : of_page, media_type, [&](const std::filesystem::path& path) {
        write_text(path, page);
        return std::map<std::string, std::string>{{"Content-Security-Policy", report_content_security_policy(page)}};
    });
}

Artefact ComparisonReports::comparison_json(const std::string& id) {
    Judged judged = judge(comparisons_.read_comparison(id));
    json curves = json::array();
    for (const MeasuredJob& job : judged.jobs) curves.push_back({{"job", job.id}, {"points", curve_json(job)}});
    judged.object["curves"] = std::move(curves);
    for (size_t r = 0; r < judged.table.rows.size(); ++r)
        judged.object["table"][r]["mean_curve"] = mean_curves_json(judged.table.rows[r]);
    const std::string text = judged.object.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
    return artefact_files_.text_artefact(cache_prefix(judged.object, "json"), text, "application/json");
}

Artefact ComparisonReports::comparison_csv(const std::string& id) {
    const Judged judged = judge(comparisons_.read_comparison(id));
    return artefact_files_.text_artefact(cache_prefix(judged.object, "csv"),
                                         report_csv(judged.jobs, judged.table.metrics), "text/csv; charset=utf-8");
}

}  // namespace photond
