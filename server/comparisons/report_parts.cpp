#include "server/comparisons/report_parts.h"

#include <vector>

#include "server/comparisons/plot.h"
#include "server/comparisons/report_page.h"
#include "server/comparisons/report_text.h"

namespace photond {

using nlohmann::json;

std::string plain(const json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

std::string paragraph(const std::string& html, const char* kind) {
    return std::string("<p") + (*kind != '\0' ? std::string(" class=\"") + kind + "\"" : "") + ">" + html + "</p>\n";
}

std::string heading(const std::string& html) { return "<h2>" + html + "</h2>\n"; }

std::string stop_text(const json& stop) {
    std::vector<std::string> conditions;
    if (stop["seconds"].is_number()) conditions.push_back(short_seconds(stop["seconds"]));
    if (stop["passes"].is_number()) conditions.push_back(plain(stop["passes"]) + " passes");
    if (stop["target"].is_object())
        conditions.push_back("a " + plain(stop["target"]["metric"]) + " of " + short_number(stop["target"]["value"]));
    std::string text;
    for (const std::string& condition : conditions) text += (text.empty() ? "" : " or ") + condition;
    return escaped(text) + (conditions.size() > 1 ? ", whichever came first" : "");
}

std::string repetition_of(const json& request, const std::string& path, const std::string& file) {
    return paragraph("The body below, every default filled in, as <code>" + file + "</code>, and a running photond:") +
           "<pre>curl -X POST http://127.0.0.1:8080" + path + " -H 'Content-Type: application/json' --data @" + file +
           "</pre>\n<pre>" + escaped(request.dump(2, ' ', false, json::error_handler_t::replace)) + "</pre>\n";
}

std::string report_page(const std::string& title, size_t series, const std::string& body) {
    return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + escaped(title) +
           "</title><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<style>" + kReportCss +
           styles_of_series(series) + "</style></head><body>\n" + body + "<script>" + kReportJs +
           "</script></body></html>\n";
}

}  // namespace photond
