#pragma once
// When a job ends, as options of a command, as the wire says it, and in words.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace photond::cli {

struct StopOptions {
    std::optional<uint32_t> passes;
    std::optional<double> seconds;          // on the job's clock
    std::vector<std::string> error_target;  // METRIC=VALUE, the last one counts

    bool any() const { return passes || seconds || !error_target.empty(); }
    /// The wire's `stop`; empty object when nothing was given. Throws Failure(Usage) for a target that is none.
    nlohmann::json body() const;
};

/// --passes, --seconds and --target; the first one met ends the job. `passes_text`: help, which says the default;
/// `passes_names`: what the first of them is called.
void add_stop_options(CLI::App& command, StopOptions& options, const char* passes_text,
                      const char* passes_names = "--passes");

/// "relative_mse=0.001" as {"metric", "value"}. Throws Failure(Usage).
nlohmann::json error_target_from(const std::string& text);

/// "64 passes or 10 s or relative_mse 0.001"; "-" when it is no stop.
std::string stop_text(const nlohmann::json& stop);

/// KEY and VALUE of "KEY=VALUE". Throws Failure(Usage) naming the option.
std::pair<std::string, std::string> key_and_value(const std::string& text, const char* option);

}  // namespace photond::cli
