// The worker program: flags, sandbox, wiring; nothing else. Started by photond, which talks to it over descriptor 3.

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <thread>

#include "protocol/error.h"
#include "server/worker/file_access.h"
#include "server/worker/process_memory.h"
#include "server/worker/sandbox.h"
#include "server/worker/video_encoder.h"
#include "server/worker/worker_loop.h"

namespace {

using Folders = std::vector<std::filesystem::path>;

std::vector<photond::FileRule> file_rules(const std::string& device, const Folders& reads, const Folders& writes) {
    std::vector<photond::FileRule> rules = photond::library_files();
    if (device.starts_with("gpu"))
        for (photond::FileRule& rule : photond::driver_files()) rules.push_back(std::move(rule));
    for (const auto& folder : reads) rules.push_back({folder, photond::FileUse::Read, true});
    for (const auto& folder : writes) rules.push_back({folder, photond::FileUse::Write, true});
    return rules;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"photond-worker: renders for photond, which starts it; not meant to be run by hand"};
    std::string device = "cpu";
    unsigned threads = 0;
    uint64_t memory_limit_bytes = 0;
    std::filesystem::path pipeline_cache;
    app.add_option(
        "--device", device,
        "cpu, gpu:N, none for the helper that judges uploads and encodes images, video to become an encoder of "
        "videos, or list to name all devices");
    app.add_option("--threads", threads, "threads to render with; 0: all cores");
    app.add_option("--memory-limit", memory_limit_bytes, "bytes a job may hold; 0: three quarters of this machine's");
    app.add_option("--pipeline-cache", pipeline_cache, "file that a GPU's compiled pipelines are kept in");
    bool warm_up = false;
    std::vector<std::filesystem::path> reads, writes;
    app.add_option("--read", reads, "folder whose files it may read; repeat for more")->take_all();
    app.add_option("--write", writes, "folder whose files it may make, write and remove; repeat for more")->take_all();
    std::filesystem::path video_program;
    app.add_option("--video-program", video_program, "what --device video becomes: ffmpeg, by its whole path");
    app.add_flag("--warm-up", warm_up, "a helper loads the image library before anybody asks for an image");
    CLI11_PARSE(app, argc, argv);
    if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
    if (memory_limit_bytes == 0) memory_limit_bytes = photond::machine_memory_bytes() / 4 * 3;

    spdlog::set_default_logger(spdlog::stderr_logger_mt("worker"));
    spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e %l photond-worker[%P] %v");
    try {
        photond::bind_to_parent(photond::kWorkerSocket);
        photond::MessageChannel channel(photond::kWorkerSocket);
        if (device == "list") return photond::list_devices(channel);
        if (!pipeline_cache.empty()) photond::keep_shader_caches_in(pipeline_cache.parent_path());
        // Bounds on files hold for threads that come later: before a driver starts its own.
        std::vector<photond::FileRule> files = file_rules(device, reads, writes);
        if (device == "video")
            for (photond::FileRule& rule : photond::video_encoder_files(video_program))
                files.push_back(std::move(rule));
        const photond::FileAccess file_access = photond::bound_file_access(files);
        photond::give_up_capabilities();
        if (device == "video") {
            photond::enter_sandbox({memory_limit_bytes, memory_limit_bytes, threads, true, true});
            photond::become_video_encoder(channel, video_program, threads);
        }
        const photond::WorkerOptions options{photond::open_device({device, pipeline_cache, memory_limit_bytes}),
                                             memory_limit_bytes, threads, file_access, warm_up};
        photond::enter_sandbox({memory_limit_bytes, memory_limit_bytes, threads, options.device.kind != "gpu"});
        return device == "none" ? run_helper(channel, options) : run_render_worker(channel, options);
    } catch (const std::exception& error) {
        spdlog::critical("{}", error.what());
        return 1;
    }
}
