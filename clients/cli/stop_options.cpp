#include "clients/cli/stop_options.h"

#include <charconv>
#include <cmath>

#include "clients/cli/failure.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

json StopOptions::body() const {
    json stop = json::object();
    if (passes) stop["passes"] = *passes;
    if (seconds) stop["seconds"] = *seconds;
    if (!error_target.empty()) stop["target"] = error_target_from(error_target.back());
    return stop;
}

void add_stop_options(CLI::App& command, StopOptions& options, const char* passes_text, const char* passes_names) {
    command.add_option(passes_names, options.passes, passes_text)->type_name("INT");
    command.add_option("--seconds", options.seconds, "stop after rendering this long")->type_name("SECONDS");
    command
        .add_option("--target", options.error_target,
                    "stop when the error is at most this, as relative_mse=0.001 or indirect:relative_mse=0.01; enough "
                    "by itself; without a reference: estimated_relative_mse=0.001")
        ->type_name("METRIC=VALUE")
        ->expected(1)
        ->take_all();
}

json error_target_from(const std::string& text) {
    const auto [metric, number] = key_and_value(text, "--target");
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (number.empty() || error != std::errc() || end != number.data() + number.size() || !std::isfinite(value))
        throw Failure(ExitCode::Usage, "--target " + printable(text) + ": " + printable(number) + " is not a number",
                      "write it as relative_mse=0.001");
    return {{"metric", metric}, {"value", value}};
}

std::string stop_text(const json& stop) {
    std::string text;
    if (!stop.is_object()) return "-";
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : " or ") + part; };
    if (stop.contains("passes") && stop["passes"].is_number())
        add(plain_text(stop["passes"]) + (stop["passes"] == 1 ? " pass" : " passes"));
    if (stop.contains("seconds") && stop["seconds"].is_number()) add(human_seconds(stop["seconds"].get<double>()));
    if (stop.contains("target") && stop["target"].is_object())
        add(plain_text(stop["target"].value("metric", json())) + " " +
            plain_text(stop["target"].value("value", json())));
    return text.empty() ? "-" : text;
}

std::pair<std::string, std::string> key_and_value(const std::string& text, const char* option) {
    const size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos)
        throw Failure(ExitCode::Usage, std::string(option) + " " + text + " is not KEY=VALUE");
    return {text.substr(0, equals), text.substr(equals + 1)};
}

}  // namespace photond::cli
