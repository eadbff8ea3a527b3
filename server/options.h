#pragma once
// What the command line settles once for the whole daemon (protocol.md, "The daemon").

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace photond {

/// Every limit of the service; each has its own answer when it is passed. All settable by flags of main.cpp.
struct Limits {
    uint64_t max_body_bytes = 2ull << 30;        // 413; scene and image uploads
    uint64_t max_json_bytes = 1ull << 20;        // 413; bodies that are JSON
    uint64_t max_pixels = 64ull << 20;           // 422; image.width * image.height
    uint32_t max_queue = 100'000;                // 429 queue_full; jobs waiting
    uint32_t max_connections = 4096;             // 503; open at once, event streams included
    double max_requests_per_second = 10'000;     // 429 too_many_requests; per token (per address without), 0: none
    uint64_t answer_memory_bytes = 32ull << 20;  // 503; answers being made or not read yet, of all clients
    uint64_t disk_reserve_bytes = 256ull << 20;  // 507; free space that is never used
    double max_job_seconds = 0;                  // timed_out; wall clock of one attempt, 0: none
    double head_timeout_seconds = 10;            // 408; for a whole request head
    double body_timeout_seconds = 600;           // 408; for a whole body
    double heartbeat_timeout_seconds = 30;       // a worker silent for longer is killed and replaced
    double helper_timeout_seconds = 120;         // one request of the helper; it is killed and replaced after that
    double shutdown_grace_seconds = 20;          // SIGTERM to exit
    uint64_t artefact_cache_bytes = 4ull << 30;  // encoded images kept; the oldest go first
};

struct Options {
    std::filesystem::path data_dir;        // absolute; made when it is missing
    std::filesystem::path worker_program;  // photond-worker, absolute
    std::string listen_address = "127.0.0.1";
    int listen_port = 8080;                      // 0: any free one
    std::vector<std::string> devices = {"cpu"};  // one worker process each
    uint64_t memory_limit_bytes = 0;             // a job may hold in a worker; 0: 75 % of RAM
    uint32_t threads = 0;                        // of each CPU worker; 0: all cores
    int worker_nice = 5;                         // so that the daemon answers while all cores render
    double save_seconds = 10;                    // between two savings of a running job's film; 0: never
    uint32_t repeats = 2;                        // of a comparison's job that was disturbed, at most
    std::filesystem::path token_file;            // empty: no authentication (loopback only)
    Limits limits;
};

}  // namespace photond
