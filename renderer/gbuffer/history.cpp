#include "renderer/gbuffer/history.h"

#include <cstring>

#include "protocol/error.h"
#include "renderer/core/copy_elements.h"

namespace photond {

namespace {

constexpr uint32_t kHistoryMagic = 0x54534948, kHistoryVersion = 1;  // "HIST"

struct HistoryHead {
    uint32_t magic, version;
    Size2 size;
    uint32_t orthographic;
    float yfov, ymag;
    vec3 position, right, up, forward;
};

template <class Visit>
void each_array(auto& history, const Visit& visit) {
    visit(history.position), visit(history.normal), visit(history.instance), visit(history.indirect);
    visit(history.frames), visit(history.near_light), visit(history.near_step);
    visit(history.step_product), visit(history.age);
}

}  // namespace

History::History(Size2 image_size) : size(image_size) {
    each_array(*this, [&](auto& values) { values.resize(size.pixels()); });
}

uint64_t History::bytes_for(Size2 image_size) {
    History pixel(Size2{1, 1});
    uint64_t bytes = 0;
    each_array(pixel, [&](const auto& values) { bytes += sizeof(values[0]); });
    return bytes * image_size.pixels();
}

std::string History::encode() const {
    const HistoryHead head{kHistoryMagic,
                           kHistoryVersion,
                           size,
                           camera.orthographic ? 1u : 0u,
                           camera.yfov,
                           camera.ymag,
                           camera.position,
                           camera.right,
                           camera.up,
                           camera.forward};
    std::string text(reinterpret_cast<const char*>(&head), sizeof head);
    text.reserve(sizeof head + bytes_for(size));
    each_array(*this, [&](const auto& values) {
        text.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
    });
    return text;
}

History History::decode(std::string_view text, Size2 image_size) {
    HistoryHead head;
    if (text.size() != sizeof head + bytes_for(image_size))
        throw Error(ErrorCode::Conflict, "the frame before left no history of an image of this size");
    std::memcpy(&head, text.data(), sizeof head);
    if (head.magic != kHistoryMagic || head.version != kHistoryVersion || !(head.size == image_size))
        throw Error(ErrorCode::Conflict, "the frame before left a history of another kind");
    History history(image_size);
    history.camera = {.name = {},
                      .orthographic = head.orthographic != 0,
                      .yfov = head.yfov,
                      .ymag = head.ymag,
                      .position = head.position,
                      .right = head.right,
                      .up = head.up,
                      .forward = head.forward};
    const char* at = text.data() + sizeof head;
    each_array(history, [&](auto& values) {
        copy_elements(at, std::span(values));
        at += values.size() * sizeof(values[0]);
    });
    return history;
}

}  // namespace photond
