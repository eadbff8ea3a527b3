#pragma once
// What a job and a comparison have in common: scene, view, light, layers, labels, stop and reference, as options of a
// command and as the wire says them.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/session.h"
#include "clients/cli/stop_options.h"

namespace photond::cli {

/// What the command line says; empty: not given, so that --request and the daemon's defaults stand.
struct RequestOptions {
    std::string scene, request_file, filter, glass, animation, camera, environment, reference, idempotency_key;
    std::optional<uint32_t> width, height;
    std::optional<double> yfov, aperture, focus_distance, environment_scale, environment_rotation, time, shutter;
    std::optional<int> priority;
    double quiet_seconds = -1;  // negative: not asked for
    std::vector<double> eye, look_at, up;
    std::vector<std::string> layers, labels, metrics;
    StopOptions stop;
};

/// The scene, and the file to start from.
void add_source_options(CLI::App& command, RequestOptions& options);
/// Size, filter, layers, labels, priority, reference and metrics. `layers`: those on request, for the help.
void add_image_options(CLI::App& command, RequestOptions& options, const std::vector<std::string>& layers);
/// Camera, environment, glass and animation, in a group of their own.
void add_view_options(CLI::App& command, RequestOptions& options);

nlohmann::json read_json_file(const std::string& file);

/// The body but for what send_parts() adds and for `stop` where the command line has none. Throws Failure(Usage).
nlohmann::json start_request(const RequestOptions& options);
/// Scene, environment and reference, which may have to be sent first. Throws Failure.
void send_parts(Session& session, nlohmann::json& request, const RequestOptions& options);

/// Posts `request` once, however often its answer is lost: an empty key is replaced by a random one.
nlohmann::json submit(Session& session, const std::string& path, const nlohmann::json& request,
                      const std::string& idempotency_key);

/// The member that is an object, made where there is none. Throws Failure(Usage) where --request has something else.
nlohmann::json& object_in(nlohmann::json& request, const char* key);

}  // namespace photond::cli
