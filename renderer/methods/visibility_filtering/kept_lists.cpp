#include "renderer/methods/visibility_filtering/kept_lists.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "renderer/core/copy_elements.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/methods/visibility_filtering/visibility_lists_gpu.h"
#include "renderer/scene/past_pose.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kListsMagic = 0x5453494c, kListsVersion = 1;  // "LIST"

struct ListsHead {
    uint32_t magic, version;
    KeptLayout layout;
    uint32_t turn;
    gpu::CameraConstants camera;
};

/// None: nobody knows what has moved.
std::optional<std::vector<Bounds3>> find_moved(const Scene& scene, const PastPose* pose) {
    if (!pose) return scene.rig ? std::nullopt : std::optional(std::vector<Bounds3>());
    std::vector<Bounds3> moved = pose->moved_bounds(scene);
    if (moved.size() <= KEPT_MOST_BOXES) return moved;
    Bounds3 all;  // one box about them all: more rays are shot again, and none is lost
    for (const Bounds3& box : moved) all.extend(box);
    return std::vector{all};
}

template <class T>
uint64_t bytes_of(const std::vector<T>& values) {
    return values.size() * sizeof(T);
}

}  // namespace

KeptLayout::KeptLayout(Size2 image_size, const VisibilityFilteringParams& params)
    : image(image_size),
      lists(VisibilityListsGpu::lists_of(image_size, params.march_subsampling)),
      rays(params.rays),
      most_lists(params.kept_lists) {}

LeftLists::LeftLists(const KeptLayout& of, const gpu::CameraConstants& seen_by)
    : layout(of),
      camera(seen_by),
      points(of.points()),
      places(of.places(), vec3(std::numeric_limits<float>::infinity())) {}

uint64_t LeftLists::bytes_for(const KeptLayout& layout) {
    return sizeof(ListsHead) + layout.points() * sizeof(gpu::KeptPoint) + layout.places() * sizeof(vec3);
}

std::string LeftLists::encode() const {
    const ListsHead head{kListsMagic, kListsVersion, layout, turn, camera};
    std::string text;
    text.reserve(bytes_for(layout));
    text.append(reinterpret_cast<const char*>(&head), sizeof head);
    text.append(reinterpret_cast<const char*>(points.data()), bytes_of(points));
    return text.append(reinterpret_cast<const char*>(places.data()), bytes_of(places));
}

LeftLists LeftLists::decode(std::string_view text, const KeptLayout& layout) {
    ListsHead head{};
    if (text.size() >= sizeof head) std::memcpy(&head, text.data(), sizeof head);
    if (head.magic != kListsMagic || head.version != kListsVersion)
        throw Error(ErrorCode::Conflict, "the frame before left no lists of voxels");
    if (!(head.layout == layout) || text.size() != bytes_for(layout))
        throw Error(ErrorCode::Conflict, "the frame before left lists of another image");
    LeftLists left(layout, head.camera);
    left.turn = head.turn;
    copy_elements(text.data() + sizeof head, std::span(left.points));
    copy_elements(text.data() + sizeof head + bytes_of(left.points), std::span(left.places));
    for (const gpu::KeptPoint& point : left.points)
        if (point.lists > layout.most_lists)
            throw Error(ErrorCode::Conflict, "the frame before left lists that cannot be");
    return left;
}

uint64_t ListsBetweenFrames::bytes_for(const VisibilityFilteringParams& params, Size2 image) {
    if (params.kept_lists == 0) return 0;
    // The frame before as text and as lists, and what this one leaves, twice while it is made.
    constexpr uint64_t kTimesLeft = 4;
    const KeptLayout layout(image, params);
    return kTimesLeft * LeftLists::bytes_for(layout) +
           layout.points() * (sizeof(gpu::TakingPoint) + layout.rays * sizeof(vec3)) + layout.places() * sizeof(vec3);
}

void ListsBetweenFrames::follow(const FrameBefore& before) {
    if (!keeps()) {
        if (!before.left.empty()) throw Error(ErrorCode::Conflict, "the method's frames stand alone");
        return;
    }
    left_before_ = before;
    followed_.follow(before.left);
}

void ListsBetweenFrames::begin(const RenderContext& context) {
    if (!keeps()) return;
    camera_ = make_eye_constants(context.view, 1, 1).camera;
    const KeptLayout layout(context.view.film_size, params_);
    before_ = LeftLists(layout, camera_);
    const FrameBefore before = std::exchange(left_before_, {});
    if (before.left.empty()) return;
    LeftLists left = LeftLists::decode(before.left, layout);
    turn_ = (left.turn + 1) % (params_.kept_lists + 1);
    std::optional<std::vector<Bounds3>> moved = find_moved(context.scene, before.pose.get());
    if (moved) before_ = std::move(left), moved_ = std::move(*moved);
}

void ListsBetweenFrames::leave(std::vector<gpu::TakingPoint> points, std::vector<vec3> met, std::vector<vec3> taken) {
    points_ = std::move(points), met_ = std::move(met), taken_ = std::move(taken);
}

std::string ListsBetweenFrames::left_to_next() const {
    if (!keeps()) return {};
    LeftLists left(before_.layout, camera_);
    left.turn = turn_;
    const size_t rays = left.layout.rays, of_point = left.layout.most_lists * rays;
    const auto copy_list = [&](const std::vector<vec3>& from, size_t at, size_t count, size_t to) {
        std::copy_n(from.begin() + static_cast<ptrdiff_t>(at), count, left.places.begin() + static_cast<ptrdiff_t>(to));
    };
    for (size_t i = 0; i < points_.size(); ++i) {
        left.points[i] = points_[i].now;
        if (left.points[i].lists == 0) continue;
        copy_list(met_, i * rays, rays, i * of_point);
        copy_list(taken_, i * of_point, (left.points[i].lists - 1) * rays, i * of_point + rays);
    }
    return left.encode();
}

}  // namespace photond
