#include "renderer/methods/visibility_filtering/kept_lists.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "renderer/eye/eye_constants.h"
#include "renderer/methods/visibility_filtering/visibility_lists_gpu.h"

namespace photond {

namespace {

constexpr uint32_t kListsMagic = 0x5453494c, kListsVersion = 1;  // "LIST"

struct ListsHead {
    uint32_t magic, version;
    KeptLayout layout;
    uint32_t turn;
    gpu::CameraConstants camera;
};

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
    std::memcpy(left.points.data(), text.data() + sizeof head, bytes_of(left.points));
    std::memcpy(left.places.data(), text.data() + sizeof head + bytes_of(left.points), bytes_of(left.places));
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
           layout.points() * (sizeof(gpu::TakingPoint) + layout.rays * sizeof(vec3));
}

void ListsBetweenFrames::follow(const FrameBefore& before) {
    if (!keeps()) {
        if (!before.left.empty()) throw Error(ErrorCode::Conflict, "the method's frames stand alone");
        return;
    }
    left_before_ = before.left;
    followed_.follow(before.left);
}

void ListsBetweenFrames::begin(const View& view) {
    if (!keeps()) return;
    camera_ = make_eye_constants(view, 1, 1).camera;
    const KeptLayout layout(view.film_size, params_);
    before_ = followed_.state().empty() ? LeftLists(layout, camera_) : LeftLists::decode(left_before_, layout);
    turn_ = followed_.state().empty() ? 0 : (before_.turn + 1) % (params_.kept_lists + 1);
    left_before_ = {};
}

void ListsBetweenFrames::leave(std::vector<gpu::TakingPoint> points, std::vector<vec3> met) {
    points_ = std::move(points), met_ = std::move(met);
}

std::string ListsBetweenFrames::left_to_next() const {
    if (!keeps()) return {};
    LeftLists left(before_.layout, camera_);
    left.turn = turn_;
    const size_t rays = left.layout.rays, of_point = left.layout.most_lists * rays;
    for (size_t i = 0; i < points_.size(); ++i) {
        const gpu::TakingPoint& point = points_[i];
        left.points[i] = point.now;
        if (point.now.lists == 0) continue;
        const auto to = left.places.begin() + static_cast<ptrdiff_t>(i * of_point);
        std::copy_n(met_.begin() + static_cast<ptrdiff_t>(i * rays), rays, to);
        if (point.taken == 0) continue;
        std::copy_n(before_.places.begin() + static_cast<ptrdiff_t>(point.from * of_point),
                    (point.now.lists - 1) * rays, to + static_cast<ptrdiff_t>(rays));
    }
    return left.encode();
}

}  // namespace photond
