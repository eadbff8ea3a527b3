#pragma once
// What the pages of reports are made of, as HTML.

#include <nlohmann/json.hpp>
#include <string>

namespace photond {

/// A text as it is, anything else as JSON; not escaped.
std::string plain(const nlohmann::json& value);
/// `kind` is the class.
std::string paragraph(const std::string& html, const char* kind = "");
std::string heading(const std::string& html);
/// Of a request's stop: "64 passes", "10 s or a relative_mse of 0.001, whichever came first".
std::string stop_text(const nlohmann::json& stop);
/// How to ask for it again: the request as a body, and the command that sends it to `path`.
std::string repetition_of(const nlohmann::json& request, const std::string& path, const std::string& file);
/// A page that needs nothing beside itself, whose `series` lines have colours; the title is not escaped yet.
std::string report_page(const std::string& title, size_t series, const std::string& body);

}  // namespace photond
