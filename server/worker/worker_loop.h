#pragma once
// The lives of a worker process: render jobs one at a time, do the helper's tasks, or say once what devices there are.

#include "protocol/message_channel.h"
#include "protocol/message_parts.h"
#include "server/worker/device.h"

namespace photond {

struct WorkerOptions {
    Device device;
    uint64_t memory_limit_bytes = 0;
    unsigned threads = 1;
    FileAccess file_access;
    bool warm_up = false;  // of a helper: the image library is loaded before anybody asks for an image
};

/// Says hello, sends heartbeats and serves messages until told to stop or the peer is gone; returns the exit status.
int run_render_worker(MessageChannel& channel, const WorkerOptions& options);
int run_helper(MessageChannel& channel, const WorkerOptions& options);

/// Sends DevicesMessage; returns the exit status.
int list_devices(MessageChannel& channel);

}  // namespace photond
