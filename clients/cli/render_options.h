#pragma once
// What the command line says of one job, as `render` and `sequence` both take it.

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/commands.h"
#include "clients/cli/request_options.h"

namespace photond::cli {

struct RenderOptions {
    RequestOptions request;
    std::string method, device;
    std::optional<uint64_t> seed;
    std::vector<std::string> settings;
    std::map<std::string, std::string> parameters;  // by wire name, from --parameter-name options
};

/// Scene, method with its parameters, stop, image and view.
void add_job_options(CLI::App& command, const std::shared_ptr<RenderOptions>& options,
                     const RenderVocabulary& vocabulary);

/// The request but for what send_parts() adds. Throws Failure(Usage) for parameters and layers that the method does not
/// have, and for a device it does not run on.
nlohmann::json job_body(Session& session, const RenderOptions& options, const CatalogueMethod& known);
/// The whole request; scene, environment and reference are sent where they are files. Throws Failure.
nlohmann::json job_request(Session& session, const RenderOptions& options, const CatalogueMethod& known);

}  // namespace photond::cli
