#pragma once
// Images that are measured, and what they are measured against, as command lines name them.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/cli/session.h"

namespace photond::cli {

/// J17 or job:J17 as "job:J17"; image:ID as it stands; a path that ends in .exr or .hdr is sent first and becomes
/// "image:ID". Throws Failure.
std::string image_from(Session& session, const std::string& text);

/// The wire's `reference`: what image_from() takes, or METHOD[,PARAMETER=VALUE...]:PASSES, which the daemon renders
/// once and keeps. Throws Failure.
nlohmann::json reference_from(Session& session, const std::string& text);

/// Metrics that are one number, as the daemon's API document (GET /v1/openapi.json) names them. Throws Failure.
std::vector<std::string> metric_names(DaemonClient& daemon);

/// A wire's `reference` in words: "path_tracing, 4096 passes", "job J17", "none".
std::string reference_text(const nlohmann::json& reference);

/// --reference and --metrics.
void add_reference_options(CLI::App& command, std::string& reference, std::vector<std::string>& metrics);
/// --metrics alone.
void add_metrics_option(CLI::App& command, std::vector<std::string>& metrics, const char* text);

}  // namespace photond::cli
