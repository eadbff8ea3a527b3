#include "clients/cli/reference_option.h"

#include <charconv>

#include "clients/cli/method_catalogue.h"
#include "clients/cli/scene_upload.h"
#include "clients/cli/stop_options.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;
using namespace nlohmann::literals;

namespace {

constexpr const char* kForms = "a job (J17), image:ID, a .exr or .hdr to send, or METHOD:PASSES as path_tracing:4096";

bool is_image_path(const std::string& text) { return text.ends_with(".exr") || text.ends_with(".hdr"); }

}  // namespace

std::string image_from(Session& session, const std::string& text) {
    if (is_image_path(text)) return "image:" + upload_image(session, text);
    if (text.starts_with("job:") || text.starts_with("image:")) return text;
    if (text.empty() || text.find_first_of(":/,=") != std::string::npos)
        throw Failure(ExitCode::Usage, printable(text) + " names no image",
                      "a job (J17), image:ID, a .exr or .hdr to send");
    return "job:" + text;
}

json reference_from(Session& session, const std::string& text) {
    const size_t colon = text.rfind(':');
    const bool by_method =
        colon != std::string::npos && !is_image_path(text) && !text.starts_with("job:") && !text.starts_with("image:");
    if (!by_method) {
        if (text.empty() || text.find_first_of(",=") != std::string::npos)
            throw Failure(ExitCode::Usage, "--reference " + printable(text) + " names none", kForms);
        return image_from(session, text);
    }
    uint32_t passes = 0;
    const char* last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data() + colon + 1, last, passes);
    if (error != std::errc() || end != last || passes == 0)
        throw Failure(
            ExitCode::Usage,
            "--reference " + printable(text) + ": " + printable(text.substr(colon + 1)) + " is no number of passes",
            kForms);
    return {{"method", MethodCatalogue(session.daemon()).method_from(text.substr(0, colon))},
            {"stop", {{"passes", passes}}}};
}

std::vector<std::string> metric_names(DaemonClient& daemon) {
    const json document = daemon.get("/v1/openapi.json");
    const json names = document.value(
        "/components/schemas/Stop/properties/target/anyOf/0/properties/metric/examples"_json_pointer, json::array());
    return names.is_array() ? names.get<std::vector<std::string>>() : std::vector<std::string>();
}

std::string reference_text(const json& reference) {
    if (reference.is_null()) return "none";
    if (!reference.is_object()) return plain_text(reference);
    const json method = reference.value("method", json::object());
    return plain_text(method.value("name", json())) + ", " + stop_text(reference.value("stop", json()));
}

void add_reference_options(CLI::App& command, std::string& reference, std::vector<std::string>& metrics) {
    command.add_option("--reference", reference, std::string("measure the error against ") + kForms)
        ->type_name("REFERENCE");
    add_metrics_option(command, metrics,
                       "errors to measure besides those that cost little, separated by commas; LAYER:METRIC is of one "
                       "layer");
}

void add_metrics_option(CLI::App& command, std::vector<std::string>& metrics, const char* text) {
    command.add_option("--metrics", metrics, text)->type_name("METRICS")->expected(1)->delimiter(',')->take_all();
}

}  // namespace photond::cli
