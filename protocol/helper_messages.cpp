#include "protocol/helper_messages.h"

namespace photond {

HelperRequest read_helper_request(const nlohmann::json& message) {
    if (auto request = message_among(message, std::type_identity<HelperRequest>())) return *std::move(request);
    throw Error(ErrorCode::UnknownName, "/type",
                "the helper has no task \"" + std::string(type_of_message(message)) + "\"");
}

}  // namespace photond
