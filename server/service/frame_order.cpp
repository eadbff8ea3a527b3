#include "server/service/frame_order.h"

#include "server/method_params.h"

namespace photond {

using nlohmann::json;

std::optional<JobRow> FrameOrder::frame_before(const JobRow& row) {
    if (row.role != JobRole::Frame || !row.comparison) return std::nullopt;
    const MethodInfo* method = find_method(row.method);
    if (!method || !method->left_to_next) return std::nullopt;
    if (left_to_next(*method, json::parse(row.request)["method"]["parameters"]).empty()) return std::nullopt;
    const std::optional<int64_t> before = core_.store.frame_before(*row.comparison, row.seq);
    return before ? core_.store.job(*before) : std::nullopt;
}

std::optional<int64_t> FrameOrder::waits_for(const JobRow& row) {
    const std::optional<JobRow> before = frame_before(row);
    return before && !is_over(before->state) ? std::optional(before->seq) : std::nullopt;
}

std::optional<RenderMessage::FrameBefore> FrameOrder::before(const JobRow& row) {
    const std::optional<JobRow> before = frame_before(row);
    if (!before || before->state != JobState::Succeeded || before->film.empty()) return std::nullopt;
    return RenderMessage::FrameBefore{core_.files.films / before->film,
                                      json::parse(before->request).value("time", 0.0)};
}

}  // namespace photond
