#include "server/service/pixel_files.h"

namespace photond {

void check_precision(const std::string& precision, BodyFaults& faults) {
    if (precision != "float" && precision != "half")
        faults.add(ErrorCode::OutOfRange, "/precision", "precision = '" + precision + "' is neither float nor half");
}

void require_precision(const std::string& precision) {
    BodyFaults faults;
    check_precision(precision, faults);
    faults.throw_if_any();
}

std::map<std::string, std::string> pixel_headers(const EncodedReply& encoded) {
    std::map<std::string, std::string> headers;
    const auto add = [&](const char* header, const auto& value) {
        if (value) headers[header] = nlohmann::json(*value).dump();
    };
    add("X-Image-Width", encoded.width);
    add("X-Image-Height", encoded.height);
    add("X-Image-Channels", encoded.channels);
    add("X-Image-Overflowed", encoded.overflowed);
    add("X-Flip-Mean", encoded.mean);
    return headers;
}

}  // namespace photond
