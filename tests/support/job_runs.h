#pragma once
// Whole jobs, run in the test as the worker does.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "protocol/worker_messages.h"
#include "renderer/film/film_file.h"
#include "server/worker/job_runner.h"

namespace photond::test {

using nlohmann::json;

/// Stages that a job's seconds leave out (conventions.md, "Clock, passes, curves").
inline bool is_off_the_clock(const std::string& stage) {
    for (const char* name : {"load", "needs", "acceleration_build", "reference_load", "error_measuring", "film_saving"})
        if (stage == name) return true;
    return false;
}

/// Runs whole jobs as the worker does and keeps what it sends.
class JobRuns : public testing::Test {
protected:
    JobRuns()
        : runner_(scenes_, open_device({"cpu", {}, 0}), 2, 4ull << 30,
                  [this](const json& message) {
                      {
                          const std::lock_guard lock(mutex_);
                          sent.push_back(message);
                      }
                      if (on_message) on_message(message);
                  }),
          film_(std::filesystem::temp_directory_path() / ("photond_job_test_" + std::to_string(getpid()) + ".film")) {}
    void TearDown() override {
        std::filesystem::remove(film_);
        std::filesystem::remove(photon_map_path());
    }

    json order(const json& changes = json::object()) const {
        json request = {{"scene", "cornell-box"},
                        {"image", {{"width", 24}, {"height", 16}}},
                        {"method", {{"name", "path_tracing"}}},
                        {"stop", {{"passes", 3}}}};
        request.merge_patch(changes);
        return {{"type", "render"},
                {"job", "J1"},
                {"attempt", 2},
                {"request", request},
                {"scene", {{"id", "cornell-box"}, {"builtin", "cornell-box"}, {"root", nullptr}, {"file", nullptr}}},
                {"environment", nullptr},
                {"film", film_.string()},
                {"limits", {{"memory_bytes", 1 << 30}, {"threads", 2}}}};
    }
    json run(const json& message, JobControl& control) {
        sent.clear();
        runner_.run(read_part<RenderMessage>(message, RenderMessage::kType), control);
        return sent.empty() ? json() : sent.back();
    }
    json run(const json& message) {
        JobControl control;
        return run(message, control);
    }
    const std::filesystem::path& film_path() const { return film_; }
    std::filesystem::path photon_map_path() const { return artefact_path(film_, "photon_map.glb"); }
    /// By photon mapping, with few photons, keeping its map unless told otherwise.
    json photon_order(const json& parameters = json::object()) const {
        json all{{"photons", 2000}, {"gather_rays", 4}, {"keep_photon_map", true}};
        all.merge_patch(parameters);
        return order({{"method", {{"name", "photon_mapping"}, {"parameters", all}}}});
    }
    SceneCache& scenes() { return scenes_; }
    std::vector<json> sent;
    std::function<void(const json& message)> on_message;  // from within the job, by two threads (film_so_far.h)

private:
    std::mutex mutex_;  // of `sent`, while a job runs
    SceneCache scenes_{1ull << 20};
    JobRunner runner_;
    std::filesystem::path film_;
};

}  // namespace photond::test
