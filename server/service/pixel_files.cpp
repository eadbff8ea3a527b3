#include "server/service/pixel_files.h"

#include <utility>

namespace photond {

using nlohmann::json;

void check_precision(const std::string& precision, BodyFaults& faults) {
    if (precision != "float" && precision != "half")
        faults.add(ErrorCode::OutOfRange, "/precision", "precision = '" + precision + "' is neither float nor half");
}

void require_precision(const std::string& precision) {
    BodyFaults faults;
    check_precision(precision, faults);
    faults.throw_if_any();
}

std::map<std::string, std::string> pixel_headers(const json& result) {
    std::map<std::string, std::string> headers;
    const std::pair<const char*, const char*> shown[] = {{"width", "X-Image-Width"},
                                                         {"height", "X-Image-Height"},
                                                         {"channels", "X-Image-Channels"},
                                                         {"overflowed", "X-Image-Overflowed"},
                                                         {"mean", "X-Flip-Mean"}};
    for (const auto& [member, header] : shown)
        if (const auto found = result.find(member); found != result.end() && found->is_number())
            headers[header] = found->dump();
    return headers;
}

}  // namespace photond
