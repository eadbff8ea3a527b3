#include "server/comparisons/sequence_html.h"

#include <cmath>

#include "server/comparisons/frame_plot.h"
#include "server/comparisons/plot.h"
#include "server/comparisons/report_parts.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

using nlohmann::json;

/// A figure of SequenceErrors and how it is drawn.
struct FrameFigure {
    const char* member;
    const char* heading;
    const char* about;
    bool logarithmic;
};

constexpr FrameFigure kFrameFigures[] = {
    {"relative_mse", "Error", "The relative mean squared error of each frame.", true},
    {"flicker", "Flicker",
     "The mean square of what changes from the frame before and does not change in the scene. Noise that is new in "
     "each "
     "frame has twice its error here, noise that stands still has none.",
     true},
    {"lag", "Lag",
     "The mean of error times change of the scene: below 0 where the image shows what was. Where nothing moves it says "
     "nothing.",
     false},
};

/// By its label "entry" where it has one, as those of a preset do.
std::string name_of(const json& sequence) {
    const json labels = sequence.at("request").value("labels", json::object());
    if (const json entry = labels.value("entry", json()); entry.is_string())
        return plain(entry) + " (" + plain(sequence.at("id")) + ")";
    const json& method = sequence.at("request").at("method");
    const std::string device = plain(method.at("device"));
    return plain(method.at("name")) + (device == "cpu" ? "" : " on " + device) + " (" + plain(sequence.at("id")) + ")";
}

std::string legend(const SequenceReport& report) {
    std::string html = "<ul class=\"legend\">";
    for (size_t i = 0; i < report.sequences.size(); ++i)
        html += "<li>" + legend_stroke(i) + escaped(name_of(report.sequences[i].sequence)) + "</li>";
    return html + "</ul>\n";
}

bool is_measured(const SequenceReport& report) { return report.sequences.front().errors.is_object(); }

std::string moments_text(const json& request) {
    std::string text = plain(request.at("frames")) + " frames, " + short_number(request.at("fps")) + " a second";
    if (request.at("from") != 0) text += ", from " + short_number(request.at("from")) + " s on";
    if (!request.value("animation", json()).is_null()) text += ", animation " + plain(request["animation"]);
    if (!request.at("camera_path").is_null()) text += ", along a path of the camera";
    if (request.value("shutter", 0.0) > 0) text += ", the shutter open for " + short_seconds(request["shutter"]);
    return text;
}

std::string header(const SequenceReport& report) {
    const json& sequence = report.sequences.front().sequence;
    const json& request = sequence.at("request");
    std::string names;
    for (const ReportedSequence& one : report.sequences)
        names += (names.empty() ? "" : " · ") + escaped(name_of(one.sequence));
    std::string html = "<header><h1>" + escaped(plain(request.at("scene"))) + ": " + names + "</h1>\n";
    html += paragraph(escaped(moments_text(request)) + "; " + plain(request.at("image").at("width")) + " × " +
                      plain(request.at("image").at("height")) + " pixels.");
    if (is_measured(report)) {
        const json& errors = report.sequences.front().errors;
        html += paragraph("Measured, layer " + escaped(plain(errors.at("layer"))) + ", against sequences " +
                          escaped(plain(errors.at("references").at(0))) + " and " +
                          escaped(plain(errors.at("references").at(1))) +
                          ", whose noise drops out: what is left of it is in the 90 % intervals.");
    }
    return html +
           paragraph(
               "photond " + escaped(report.version) + ", asked for on " + escaped(plain(sequence.at("created"))) + ".",
               "soft") +
           "</header>\n";
}

std::string state_notes(const SequenceReport& report) {
    std::string html;
    for (const auto& [sequence, errors, sheet] : report.sequences) {
        if (sequence.at("state") == "succeeded") continue;
        html += paragraph(escaped(name_of(sequence)) + " is " + escaped(plain(sequence.at("state"))) + ": " +
                              plain(sequence.at("job_states").at("succeeded")) + " of " +
                              std::to_string(sequence.at("frames").size()) +
                              " frames have succeeded. What follows is of those.",
                          "unfinished warning");
    }
    for (const std::string& note : report.notes) html += paragraph(escaped(note), "warning");
    return html;
}

/// "0.012", its interval below; or a dash.
std::string figure_cell(const json& figure) {
    if (!figure.is_object()) return "<td>–</td>";
    const json& interval = figure.at("interval");
    return "<td>" + short_number(figure.at("value")) + "<small>" + range(interval.at(0), interval.at(1), short_number) +
           "</small></td>";
}

std::string ratio_cell(const json& above, const json& below) {
    if (!above.is_object() || !below.is_object() || !(below.at("interval").at(0).get<double>() > 0))
        return "<td>–</td>";
    return "<td>" + short_number(above.at("value").get<double>() / below.at("value").get<double>()) + "</td>";
}

std::string seconds_cell(const json& frames) {
    double sum = 0;
    size_t count = 0;
    for (const json& frame : frames)
        if (frame.at("state") == "succeeded") sum += frame.at("seconds").get<double>(), ++count;
    return "<td>" + (count > 0 ? short_seconds(sum / static_cast<double>(count)) : std::string("–")) + "</td>";
}

std::string means_table(const SequenceReport& report) {
    std::string html =
        "<div class=\"scroll\"><table><thead><tr><th>in the mean over frames</th><th>each ended "
        "at</th><th>seconds</th>";
    if (is_measured(report))
        html +=
            "<th>relative_mse</th><th>flicker</th><th>flicker / error</th><th>lag</th><th>frames late</th><th>motion "
            "of the scene</th>";
    html += "</tr></thead><tbody>";
    for (size_t i = 0; i < report.sequences.size(); ++i) {
        const auto& [sequence, errors, sheet] = report.sequences[i];
        html += "<tr><td>" + legend_stroke(i) + escaped(name_of(sequence)) + "</td><td>" +
                stop_text(sequence.at("request").at("stop")) + "</td>" + seconds_cell(sequence.at("frames"));
        if (errors.is_object()) {
            const json& mean = errors.at("mean");
            const json& late = errors.at("frames_late");
            html +=
                figure_cell(mean.at("relative_mse")) + figure_cell(mean.at("flicker")) +
                ratio_cell(mean.at("flicker"), mean.at("relative_mse")) + figure_cell(mean.at("lag")) + "<td>" +
                (late.is_number() ? short_number(std::round(100 * late.get<double>()) / 100 + 0.0) : std::string("–")) +
                "</td>" + figure_cell(mean.at("change"));
        }
        html += "</tr>";
    }
    return html + "</tbody></table></div>\n";
}

FrameSeries series_of(const ReportedSequence& one, const char* member) {
    FrameSeries series{name_of(one.sequence), {}};
    for (const json& frame : one.errors.at("frames"))
        if (const json& figure = frame.at(member); figure.is_object())
            series.points.push_back({frame.at("frame").get<double>(),
                                     figure.at("value"),
                                     {figure.at("interval").at(0), figure.at("interval").at(1)}});
    return series;
}

std::string curves(const SequenceReport& report) {
    if (!is_measured(report))
        return paragraph(
            "Not measured: two more sequences of the same frames, whose seeds are far apart, tell the error "
            "of each frame (<code>report.html?first=ID&amp;second=ID</code>).",
            "soft");
    std::string html;
    for (const FrameFigure& figure : kFrameFigures) {
        FramePlot asked{figure.heading + std::string(" by frame"), figure.member, figure.logarithmic, {}};
        for (const ReportedSequence& one : report.sequences) asked.series.push_back(series_of(one, figure.member));
        const std::string svg = frame_plot(asked);
        html += heading(figure.heading) + paragraph(figure.about, "soft") +
                (svg.empty() ? paragraph("Nothing has been measured yet.", "soft") : legend(report) + svg + "\n");
    }
    return html;
}

std::string sheets(const SequenceReport& report) {
    std::string html;
    for (const auto& [sequence, errors, sheet] : report.sequences)
        if (!sheet.empty())
            html += "<h3>" + escaped(name_of(sequence)) + "</h3>\n<figure><img alt=\"frames of " +
                    escaped(name_of(sequence)) + "\" src=\"data:image/png;base64," + base64(sheet) + "\"></figure>\n";
    return html.empty() ? "" : heading("Frames") + html;
}

std::string repetition(const SequenceReport& report) {
    std::string html = heading("To repeat it");
    for (const ReportedSequence& one : report.sequences)
        html += "<h3>" + escaped(name_of(one.sequence)) + "</h3>\n" +
                repetition_of(one.sequence.at("request"), "/v1/sequences", "sequence.json");
    return html;
}

}  // namespace

std::string sequence_html(const SequenceReport& report) {
    const json& first = report.sequences.front().sequence;
    const std::string title = plain(first.at("request").at("scene")) + ": sequence " + plain(first.at("id"));
    return report_page(title, report.sequences.size(),
                       header(report) + state_notes(report) + means_table(report) + curves(report) + sheets(report) +
                           repetition(report));
}

}  // namespace photond
