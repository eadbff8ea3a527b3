#include "server/comparisons/report_html.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "renderer/error/color_map.h"
#include "server/comparisons/headline.h"
#include "server/comparisons/left_out_marks.h"
#include "server/comparisons/plot.h"
#include "server/comparisons/report_parts.h"
#include "server/comparisons/report_tables.h"
#include "server/comparisons/report_text.h"
#include "server/comparisons/verdict.h"

namespace photond {
namespace {

using nlohmann::json;

bool is_over(const Report& report) {
    const std::string state = report.comparison.at("state");
    return state != "queued" && state != "running";
}

std::string reference_text(const json& reference) {
    if (reference.is_null()) return "no reference: errors are estimated from the passes";
    if (reference.is_string()) return escaped(reference.get<std::string>());
    return escaped(plain(reference["method"]["name"])) + " on " + escaped(plain(reference["method"]["device"])) + ", " +
           stop_text(reference["stop"]);
}

/// How errors were measured against the reference of a comparison; what has no form is of before there were two films.
std::string form_text(const json& reference) {
    if (reference.is_null()) return "";
    const json form = reference.value("form", json());
    if (form == "two_films")
        return "Measured against two films of different seeds, each with half of the passes: of mse, rmse and "
               "relative_mse the references' noise drops out, and what is left of it is in their 90 % intervals. Other "
               "measures are against the mean of both, and its noise is part of them.";
    return std::string("Measured against one ") + (form == "image" ? "image" : "film") +
           ": its own noise is part of every error.";
}

/// What people have said of the comparison; empty where they have not.
std::string said(const json& request, const char* what) {
    const auto found = request.find(what);
    return found != request.end() && found->is_string() ? found->get<std::string>() : "";
}

std::string header(const Report& report) {
    const json& comparison = report.comparison;
    const json& request = comparison.at("request");
    std::string labels;
    for (const json& entry : request["entries"])
        labels += (labels.empty() ? "" : " · ") + escaped(plain(entry["label"]));
    std::string seeds;
    for (const json& seed : request["seeds"]) seeds += (seeds.empty() ? "" : ", ") + plain(seed);
    const std::string what = escaped(plain(request["scene"])) + ": " + labels, title = said(request, "title");
    std::string html = "<header><h1>" + (title.empty() ? what : escaped(title)) + "</h1>\n";
    if (!title.empty()) html += paragraph(what);
    std::istringstream notes(said(request, "notes"));
    for (std::string line; std::getline(notes, line);)
        if (!line.empty()) html += paragraph(escaped(line), "notes");
    html += paragraph("Comparison " + escaped(plain(comparison["id"])) + " of " +
                      std::to_string(comparison["jobs"].size()) + " jobs, " + plain(request["image"]["width"]) + " × " +
                      plain(request["image"]["height"]) + " pixels, seed" + (request["seeds"].size() > 1 ? "s " : " ") +
                      seeds + "; each job ended at " + stop_text(request["stop"]) + ".");
    html += paragraph("Reference: " + reference_text(request["reference"]) + ". " + form_text(comparison["reference"]));
    html += paragraph("photond " + escaped(report.version) + ", asked for on " + escaped(plain(comparison["created"])) +
                          (comparison["overhead_seconds"].is_number()
                               ? "; " + short_seconds(comparison["overhead_seconds"]) +
                                     " were spent beside the jobs' clocks (loading, building, measuring, saving)"
                               : "") +
                          ".",
                      "soft");
    return html + "</header>\n";
}

std::string state_note(const Report& report) {
    const json& comparison = report.comparison;
    const json& states = comparison.at("job_states");
    const std::string done = plain(states["succeeded"]) + " of " + std::to_string(comparison["jobs"].size()) + " jobs";
    if (!is_over(report))
        return paragraph("Unfinished: " + done + " have succeeded. What follows is of what is there so far.",
                         "unfinished warning");
    if (comparison["state"] == "succeeded") return "";
    return paragraph(
        "The comparison " +
            (comparison["state"] == "failed" ? std::string("failed in part") : std::string("was cancelled")) + ": " +
            done + " succeeded. What follows is of those.",
        "unfinished warning");
}

std::string reference_warnings(const Report& report) {
    const json& reference = report.comparison.at("reference");
    if (reference.is_null()) return "";
    std::string html;
    for (const json& warning : reference["warnings"]) html += "<li>" + escaped(plain(warning)) + "</li>";
    return html.empty() ? "" : "<ul class=\"first warning\">" + html + "</ul>\n";
}

/// Which rows have light that the reference lacks.
std::string marks_list(const Report& report) {
    std::string html;
    for (const TableRow& row : report.table.rows)
        if (const std::string mark = mark_text(report.table, row); !mark.empty())
            html += "<li>" + escaped(row_name(row.label, row.parameters) + ": " + mark) + ".</li>";
    return html.empty() ? "" : "<ul class=\"first warning\">" + html + "</ul>\n";
}

std::string left_out_list(const ComparisonTable& table) {
    const auto item = [](const std::string& name, const std::optional<PathsLeftOut>& left_out) {
        return left_out && !left_out->empty() ? "<li>" + escaped(name + ": " + left_out->text()) + ".</li>" : "";
    };
    std::string html = item("The reference", table.reference_left_out);
    for (const TableRow& row : table.rows) html += item(row_name(row.label, row.parameters), row.left_out);
    return html.empty() ? "" : heading("What is left out") + "<ul class=\"first\">" + html + "</ul>\n";
}

/// Which jobs were disturbed, and what became of that.
std::string disturbance_warnings(const Report& report) {
    std::string html;
    for (const json& warning : report.comparison.at("warnings")) html += "<li>" + escaped(plain(warning)) + ".</li>";
    return html.empty() ? "" : "<ul class=\"first warning\">" + html + "</ul>\n";
}

std::string verdict_section(const Report& report) {
    const std::vector<Verdict> found = verdicts(report.table);
    if (found.empty()) return "";
    std::string html;
    for (const Headline& headline : headlines(report.table, found))
        html += paragraph((headline.row ? legend_stroke(*headline.row) : "") + "By " + escaped(headline.metric) + ": " +
                              escaped(headline_text(report.table, headline)) + ".",
                          "headline");
    html += "<ul class=\"first\">";
    for (const Verdict& verdict : found) html += "<li>" + escaped(verdict_text(report.table, verdict)) + "</li>";
    html += "</ul>\n";
    const bool one_seed = report.comparison.at("request")["seeds"].size() == 1;
    return heading("Who reaches which error first") + html +
           (one_seed ? paragraph("One seed: how far another would be from these times is not known. More seeds give "
                                 "intervals.",
                                 "soft")
                     : "");
}

std::string legend(const ComparisonTable& table) {
    std::string html = "<ul class=\"legend\">";
    for (size_t r = 0; r < table.rows.size(); ++r)
        html += "<li>" + legend_stroke(r) + escaped(row_name(table.rows[r].label, table.rows[r].parameters)) + "</li>";
    return html + "</ul>\n";
}

/// What the lines of a metric's plot are.
std::string key_text(const ComparisonTable& table, const std::string& metric) {
    bool intervals = false, floors = false;
    for (const TableRow& row : table.rows) {
        for (const MeanPoint& point : row.mean_curve.at(metric)) intervals = intervals || point.mean.interval;
        floors = floors || floor_of(row, metric);
    }
    if (!intervals) return "Lines: the mean over the seeds (of logarithms); bands: its 95 % interval.";
    return std::string(
               "Lines: the mean over the seeds; bands: its 95 % interval; whiskers: where the references' noise "
               "lets it lie, at 90 %; arrows down: upper bounds, where it is not told apart from 0") +
           (floors ? "; dotted: the least that bias leaves of it, which more passes will not go below" : "") + ".";
}

std::string bias_list(const ComparisonTable& table, const std::string& metric) {
    std::string html;
    for (size_t r = 0; r < table.rows.size(); ++r)
        if (const BiasApart* parts = bias_of(table.rows[r], metric))
            html += "<li>" + legend_stroke(r) + escaped(row_name(table.rows[r].label, table.rows[r].parameters)) +
                    ": " + escaped(parts->text) + "</li>";
    return html.empty() ? "" : "<ul class=\"first\">" + html + "</ul>\n";
}

std::string metric_section(const ComparisonTable& table, const std::string& metric) {
    Plot plot{metric + " against time", metric, {}, std::nullopt};
    for (const TableRow& row : table.rows) {
        plot.series.push_back({row_name(row.label, row.parameters), row.mean_curve.at(metric), floor_of(row, metric)});
        const FinalError& end = row.error.at(metric);
        const bool in_interval = end.mean && end.mean->interval;
        if (end.reference && !in_interval) plot.reference_noise = end.reference;
    }
    const std::string svg = log_log_plot(plot);
    if (svg.empty()) return heading(escaped(metric)) + paragraph("Nothing has been measured yet.", "soft");
    return heading(escaped(metric)) + legend(table) + svg + "\n" + paragraph(key_text(table, metric), "soft") +
           bias_list(table, metric) + time_to_error_table(table, metric) + "<p></p>" +
           error_at_time_table(table, metric);
}

std::string image_element(const ReportPicture& picture, bool in_wipe) {
    const std::string name = escaped(picture.name);
    return "<figure><img alt=\"" + name + "\"" + (in_wipe ? " data-picture=\"" + name + "\"" : "") +
           " src=\"data:image/png;base64," + base64(picture.png) + "\"><figcaption>" + name + " (" +
           escaped(picture.job) + ")</figcaption></figure>\n";
}

/// The colours of a map and what they stand for: `marks` are places in [0, 1] and their texts.
std::string scale_bar(const char* id, const std::vector<std::pair<double, std::string>>& marks) {
    constexpr int kStops = 16;
    constexpr double kWidth = 460, kInset = 10;
    std::vector<float> values;
    for (int i = 0; i <= kStops; ++i) values.push_back(static_cast<float>(i) / kStops);
    const std::vector<uint8_t> colors = color_mapped(values);
    std::string svg = "<svg class=\"scale\" viewBox=\"0 0 480 46\" aria-hidden=\"true\"><linearGradient id=\"" +
                      std::string(id) + "\">";
    for (size_t i = 0; i <= kStops; ++i)
        svg += "<stop offset=\"" + short_number(static_cast<double>(i) / kStops) + "\" stop-color=\"rgb(" +
               std::to_string(colors[3 * i]) + "," + std::to_string(colors[3 * i + 1]) + "," +
               std::to_string(colors[3 * i + 2]) + ")\"/>";
    svg +=
        "</linearGradient><rect x=\"10\" y=\"4\" width=\"460\" height=\"16\" fill=\"url(#" + std::string(id) + ")\"/>";
    for (const auto& [at, text] : marks)
        svg += "<text x=\"" + short_number(kInset + kWidth * at) + "\" y=\"38\" text-anchor=\"" +
               (at == 0   ? "start"
                : at == 1 ? "end"
                          : "middle") +
               "\">" + text + "</text>";
    return svg + "</svg>\n";
}

std::string grid(const Report& report, ReportPicture::Kind kind) {
    std::string html;
    for (const ReportPicture& picture : report.pictures)
        if (picture.kind == kind) html += image_element(picture, kind == ReportPicture::Kind::Beauty);
    return html.empty() ? "" : "<div class=\"pictures\">\n" + html + "</div>\n";
}

constexpr const char* kWipe =
    R"(<div id="wipe" hidden><div id="wipe-choice"><label>left <select id="wipe-left"></select></label>
<label>right <select id="wipe-right"></select></label></div>
<div id="wipe-stage"><img id="wipe-under" alt=""><img id="wipe-over" alt=""><div id="wipe-line"></div></div>
<input id="wipe-at" type="range" min="0" max="1000" value="500" aria-label="where the two images part"></div>
)";

std::string pictures(const Report& report) {
    std::string html;
    if (const std::string images = grid(report, ReportPicture::Kind::Beauty); !images.empty())
        html += paragraph("First seed of each row, all at one exposure of " + short_number(report.exposure_stops) +
                          " stops, sRGB.") +
                kWipe + images;
    if (const std::string maps = grid(report, ReportPicture::Kind::Error); !maps.empty())
        html += "<h3>Relative error of each pixel</h3>\n" +
                scale_bar("error-scale", {{0, "0.001"}, {0.25, "0.01"}, {0.5, "0.1"}, {0.75, "1"}, {1, "10"}}) + maps;
    if (const std::string maps = grid(report, ReportPicture::Kind::Flip); !maps.empty())
        html += "<h3>HDR-FLIP</h3>\n" + scale_bar("flip-scale", {{0, "0"}, {0.5, "0.5"}, {1, "1"}}) + maps;
    for (const std::string& note : report.notes) html += paragraph(escaped(note), "soft");
    return html.empty() ? "" : heading("Images") + html;
}

/// Bytes of each structure (statistics.memory), on the host and on its device, of each row's first job that has
/// statistics.
std::string structures_table(const Report& report) {
    const json& jobs = report.comparison.at("jobs");
    std::vector<std::pair<std::string, json>> rows;
    std::set<std::string> names, seen;
    for (size_t i = 0; i < std::min(jobs.size(), report.statistics.size()); ++i) {
        const json& statistics = report.statistics[i];
        const json memory = statistics.is_object() ? statistics.value("memory", json()) : json();
        json structures = memory.is_object() ? memory.value("structures", json()) : json();
        const std::string name = row_name(plain(jobs[i]["label"]), jobs[i]["parameters"]);
        if (!structures.is_object() || !seen.insert(name).second) continue;
        const json on_device = memory.value("device_structures", json());
        if (on_device.is_object())
            for (const auto& [structure, bytes] : on_device.items()) structures["device: " + structure] = bytes;
        for (const auto& [structure, bytes] : structures.items()) names.insert(structure);
        rows.emplace_back(name, structures);
    }
    if (names.empty()) return "";
    std::string html = "<p></p><div class=\"scroll\"><table><caption>Memory by structure</caption><thead><tr><th></th>";
    for (const std::string& name : names) html += "<th>" + escaped(name) + "</th>";
    html += "</tr></thead><tbody>";
    for (const auto& [name, structures] : rows) {
        html += "<tr><td>" + escaped(name) + "</td>";
        for (const std::string& structure : names) {
            const json bytes = structures.value(structure, json());
            html += "<td>" + (bytes.is_number_unsigned() ? short_bytes(bytes.get<uint64_t>()) : "–") + "</td>";
        }
        html += "</tr>";
    }
    return html + "</tbody></table></div>\n";
}

/// Where a row's time went: wall seconds of each stage of its first job that has statistics, and the GPU's own.
std::string stages_table(const Report& report) {
    const json& jobs = report.comparison.at("jobs");
    std::vector<std::pair<std::string, json>> rows;
    std::vector<std::string> names;
    std::set<std::string> seen;
    for (size_t i = 0; i < std::min(jobs.size(), report.statistics.size()); ++i) {
        const json& statistics = report.statistics[i];
        const json stages = statistics.is_object() ? statistics.value("stages", json()) : json();
        const std::string name = row_name(plain(jobs[i]["label"]), jobs[i]["parameters"]);
        if (!stages.is_array() || !seen.insert(name).second) continue;
        for (const json& stage : stages)
            if (const std::string stage_name = plain(stage.at("name"));
                std::find(names.begin(), names.end(), stage_name) == names.end())
                names.push_back(stage_name);
        rows.emplace_back(name, stages);
    }
    if (names.empty()) return "";
    std::string html =
        "<p></p><div class=\"scroll\"><table><caption>Seconds by stage, of the clock and (gpu) of the device; stages "
        "of the device run within others of the clock</caption><thead><tr><th></th>";
    for (const std::string& name : names) html += "<th>" + escaped(name) + "</th>";
    html += "</tr></thead><tbody>";
    for (const auto& [name, stages] : rows) {
        html += "<tr><td>" + escaped(name) + "</td>";
        for (const std::string& stage_name : names) {
            std::string cell;
            for (const json& stage : stages) {
                if (stage.at("name") != stage_name) continue;
                const json wall = stage.value("wall_seconds", json()), gpu = stage.value("gpu_seconds", json());
                if (wall.is_number() && wall.get<double>() > 0) cell = short_seconds(wall);
                if (gpu.is_number()) cell += (cell.empty() ? "" : ", ") + short_seconds(gpu) + " gpu";
            }
            html += "<td>" + (cell.empty() ? std::string("–") : cell) + "</td>";
        }
        html += "</tr>";
    }
    return html + "</tbody></table></div>\n";
}

/// "98.7 %": of the processor time that it wanted.
std::string share_text(const json& statistics) {
    const json cores = statistics.is_object() ? statistics.value("cores", json()) : json();
    const json share = cores.is_object() ? cores.value("share", json()) : json();
    return share.is_number() ? short_number(100 * share.get<double>()) + " %" : "–";
}

std::string jobs_table(const Report& report) {
    std::string html =
        "<div class=\"scroll\"><table><thead><tr><th>row</th><th>job</th><th>seed</th><th>state</th><th>passes</th>"
        "<th>seconds</th><th>had of its cores</th><th>device</th><th>threads</th><th>version</th><th>job "
        "hash</th><th>pixel hash</th></tr>"
        "</thead><tbody>";
    const json& jobs = report.comparison.at("jobs");
    for (size_t i = 0; i < jobs.size(); ++i) {
        const json& job = jobs[i];
        const json statistics = i < report.statistics.size() ? report.statistics[i] : json();
        const auto fact = [&](const char* key) {
            const json value = statistics.is_object() ? statistics.value(key, json()) : json();
            return value.is_null() ? std::string("–") : escaped(plain(value));
        };
        const json device = statistics.is_object() ? statistics.value("device", json()) : json();
        const json driver = device.is_object() ? device.value("driver", json()) : json();
        html += "<tr><td>" + escaped(row_name(plain(job["label"]), job["parameters"])) + "</td><td>" +
                escaped(plain(job["id"])) + "</td><td>" + plain(job["seed"]) + "</td><td>" +
                escaped(plain(job["state"])) + "</td><td>" + plain(job["passes_done"]) + "</td><td>" +
                short_seconds(job["seconds"]) + "</td><td>" + share_text(statistics) + "</td><td class=\"text\">" +
                (device.is_object() ? escaped(plain(device.value("name", json("–")))) : "–") +
                (driver.is_string() ? ", " + escaped(plain(driver)) : "") + "</td><td>" + fact("threads") +
                "</td><td>" + fact("version") + "</td><td class=\"hash\">" + fact("job_hash") +
                "</td><td class=\"hash\">" + fact("pixel_hash") + "</td></tr>";
    }
    return html + "</tbody></table></div>\n";
}

std::string repetition(const Report& report) {
    const json& request = report.comparison.at("request");
    return heading("To repeat it") + repetition_of(request, "/v1/comparisons", "comparison.json") +
           paragraph(
               "The same passes give the same pixels: a job stopped by time or target is repeated to the bit with "
               "<code>passes</code> set to the number it did.") +
           jobs_table(report);
}

}  // namespace

std::string report_html(const Report& report) {
    std::string html;
    html += header(report) + state_note(report) + disturbance_warnings(report) + verdict_section(report) +
            reference_warnings(report) + marks_list(report);
    for (const std::string& metric : report.table.metrics) html += metric_section(report.table, metric);
    html += heading("What it cost") + cost_table(report.table) + structures_table(report) + stages_table(report);
    html += pictures(report) + left_out_list(report.table) + repetition(report);
    html +=
        "<footer>Times run on the jobs' own clocks: the method's beginning, its passes and its end; loading, "
        "building and measuring are outside. Errors as photond's conventions define them.</footer>\n";
    const json& request = report.comparison.at("request");
    const std::string name = said(request, "title"), title = (name.empty() ? plain(request["scene"]) : name) +
                                                             ": comparison " + plain(report.comparison.at("id"));
    return report_page(title, report.table.rows.size(), html);
}

std::string report_content_security_policy(const std::string& page) {
    const auto between = [&page](const std::string& begin, const std::string& end) {
        const size_t from = page.find(begin) + begin.size();
        return std::string_view(page).substr(from, page.find(end, from) - from);
    };
    return "default-src 'none'; img-src data:; style-src 'sha256-" + sha256_base64(between("<style>", "</style>")) +
           "'; script-src 'sha256-" + sha256_base64(between("<script>", "</script>")) +
           "'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

}  // namespace photond
