#include "protocol/worker_messages.h"

namespace photond {

std::optional<WorkerMessage> read_worker_message(const nlohmann::json& message) {
    return message_among(message, std::type_identity<WorkerMessage>());
}

std::optional<DaemonMessage> read_daemon_message(const nlohmann::json& message) {
    return message_among(message, std::type_identity<DaemonMessage>());
}

}  // namespace photond
