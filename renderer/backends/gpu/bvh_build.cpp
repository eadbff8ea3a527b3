// [Ylitie, Karras, Laine 2017] Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs. HPG.
// [Embree] rtcBuildBVH makes the binary tree, one primitive a leaf.

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <memory>

#include "protocol/error.h"
#include "renderer/backends/gpu/bvh.h"
#include "renderer/scene/scene.h"

namespace photond::gpu {

namespace {

// The surface-area heuristic's prices of visiting a wide node and of testing a triangle.
constexpr float kNodeCost = 1.0f, kTriangleCost = 0.3f;
constexpr uint32_t kWidth = 8, kLeafSize = 3;

struct DeviceRelease {
    void operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
};
struct BvhRelease {
    void operator()(RTCBVHTy* bvh) const { rtcReleaseBVH(bvh); }
};

float half_area(const Bounds3& b) {
    const vec3 d = b.diagonal();
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// What a tree is built over: a box and the record that stands for it in a leaf.
struct Primitive {
    Bounds3 bounds;
    BvhTriangle record;
};

/// Children precede their parents; the root is the last.
struct BinaryNode {
    Bounds3 bounds;
    uint32_t children[2];
    uint32_t primitive;
    uint32_t primitives;  // below it; 1: a leaf
};

/// A node as Embree makes it.
struct EmbreeNode {
    Bounds3 bounds;
    EmbreeNode* children[2];
    uint32_t primitive;
};

Bounds3 bounds_of(const RTCBounds& b) {
    return {vec3(b.lower_x, b.lower_y, b.lower_z), vec3(b.upper_x, b.upper_y, b.upper_z)};
}

uint32_t append(const EmbreeNode& node, std::vector<BinaryNode>& nodes) {
    BinaryNode out{node.bounds, {0, 0}, node.primitive, 1};
    if (node.children[0]) {
        out.children[0] = append(*node.children[0], nodes);
        out.children[1] = append(*node.children[1], nodes);
        const BinaryNode &left = nodes[out.children[0]], &right = nodes[out.children[1]];
        out.bounds = left.bounds;
        out.bounds.extend(right.bounds);
        out.primitives = left.primitives + right.primitives;
    }
    nodes.push_back(out);
    return static_cast<uint32_t>(nodes.size() - 1);
}

std::vector<BinaryNode> build_binary_tree(RTCDevice device, std::span<const Primitive> primitives) {
    std::vector<RTCBuildPrimitive> boxes(primitives.size());
    for (uint32_t i = 0; i < boxes.size(); ++i) {
        const Bounds3& b = primitives[i].bounds;
        boxes[i] = {b.min.x, b.min.y, b.min.z, 0, b.max.x, b.max.y, b.max.z, i};
    }
    const std::unique_ptr<RTCBVHTy, BvhRelease> bvh(rtcNewBVH(device));
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxDepth = 64;
    arguments.maxLeafSize = 1;
    arguments.bvh = bvh.get();
    arguments.primitives = boxes.data();
    arguments.primitiveCount = arguments.primitiveArrayCapacity = boxes.size();
    arguments.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void*) -> void* {
        return new (rtcThreadLocalAlloc(allocator, sizeof(EmbreeNode), 16)) EmbreeNode{};
    };
    arguments.setNodeChildren = [](void* node, void** children, unsigned, void*) {
        for (int i = 0; i < 2; ++i) static_cast<EmbreeNode*>(node)->children[i] = static_cast<EmbreeNode*>(children[i]);
    };
    arguments.setNodeBounds = [](void*, const RTCBounds**, unsigned, void*) {};  // follow from the leaves
    arguments.createLeaf = [](RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitive, size_t,
                              void*) -> void* {
        RTCBounds bounds;
        std::memcpy(&bounds, primitive, sizeof bounds);
        return new (rtcThreadLocalAlloc(allocator, sizeof(EmbreeNode), 16))
            EmbreeNode{bounds_of(bounds), {nullptr, nullptr}, primitive->primID};
    };
    const auto* root = static_cast<const EmbreeNode*>(rtcBuildBVH(&arguments));
    if (!root)
        throw Error(ErrorCode::Internal,
                    "Embree builds no tree: its error is " + std::to_string(int(rtcGetDeviceError(device))));
    std::vector<BinaryNode> nodes;
    nodes.reserve(2 * primitives.size() - 1);
    append(*root, nodes);
    return nodes;
}

/// Which binary nodes become the children of a wide one: the choice that costs least by the surface-area heuristic,
/// found from the leaves up [Ylitie et al. 2017, section 3.1].
class WideChoice {
public:
    explicit WideChoice(std::span<const BinaryNode> nodes) : nodes_(nodes), choices_(nodes.size()) {
        for (size_t i = 0; i < nodes.size(); ++i) decide(i);
    }

    /// The binary nodes that are children of the wide node made of this one; a leaf is its own only child.
    void children(uint32_t node, std::vector<uint32_t>& out) const {
        if (nodes_[node].primitives == 1)
            out.push_back(node);
        else
            distribute(node, kWidth, out);
    }
    /// Whether a child is a leaf with all primitives below it.
    bool is_leaf(uint32_t node) const { return choices_[node].leaf; }

private:
    /// Least costs of giving the node's primitives to up to i + 1 subtrees, and how.
    struct Choice {
        float cost[kWidth - 1];
        uint8_t left[kWidth];  // of i + 1 subtrees, those of the left child; 0: it takes less than i + 1
        bool leaf;
    };

    void decide(size_t index) {
        const BinaryNode& node = nodes_[index];
        Choice& choice = choices_[index];
        const float area = half_area(node.bounds), leaf_cost = area * float(node.primitives) * kTriangleCost;
        choice.leaf = true;
        if (node.primitives == 1) {
            std::fill_n(choice.cost, kWidth - 1, leaf_cost);
            std::fill_n(choice.left, kWidth, uint8_t{0});
            return;
        }
        const Choice &left = choices_[node.children[0]], &right = choices_[node.children[1]];
        const auto least = [&](uint32_t subtrees, uint8_t& best_left) {
            float best = kInfinity;
            for (uint32_t k = 1; k < subtrees; ++k) {
                const float cost = left.cost[k - 1] + right.cost[subtrees - k - 1];
                if (cost < best || k == 1) best = cost, best_left = uint8_t(k);
            }
            return best;
        };
        const float node_cost = least(kWidth, choice.left[kWidth - 1]) + area * kNodeCost;
        choice.leaf = node.primitives <= kLeafSize && leaf_cost <= node_cost;
        choice.left[0] = 0;
        choice.cost[0] = choice.leaf ? leaf_cost : node_cost;
        for (uint32_t subtrees = 2; subtrees < kWidth; ++subtrees) {
            const float cost = least(subtrees, choice.left[subtrees - 1]);
            choice.cost[subtrees - 1] = cost;
            if (cost < choice.cost[subtrees - 2]) continue;
            choice.cost[subtrees - 1] = choice.cost[subtrees - 2];
            choice.left[subtrees - 1] = 0;
        }
    }

    void distribute(uint32_t node, uint32_t subtrees, std::vector<uint32_t>& out) const {
        while (subtrees > 1 && choices_[node].left[subtrees - 1] == 0) --subtrees;
        if (subtrees == 1) {
            out.push_back(node);
            return;
        }
        const uint32_t left = choices_[node].left[subtrees - 1];
        distribute(nodes_[node].children[0], left, out);
        distribute(nodes_[node].children[1], subtrees - left, out);
    }

    std::span<const BinaryNode> nodes_;
    std::vector<Choice> choices_;
};

/// Which slot each child gets: slot bits 4, 2 and 1 are set for the child on the lower side in x, y and z, so that a
/// ray visits slots in falling order of slot XOR its octant (bits set where its direction is negative). Greedily, the
/// child that would lose most first [Ylitie et al. 2017, section 3.2; theirs is an auction].
std::array<int, kWidth> assign_slots(const Bounds3& box, std::span<const Bounds3> children) {
    float gain[kWidth][kWidth] = {};
    for (size_t c = 0; c < children.size(); ++c) {
        const vec3 d = children[c].centre() - box.centre();
        for (uint32_t s = 0; s < kWidth; ++s)
            gain[c][s] = (s & 4 ? -d.x : d.x) + (s & 2 ? -d.y : d.y) + (s & 1 ? -d.z : d.z);
    }
    std::array<int, kWidth> child_of;
    child_of.fill(-1);
    uint32_t placed = 0;
    for (size_t round = 0; round < children.size(); ++round) {
        size_t best_child = 0, best_slot = 0;
        float best = -kInfinity;
        for (size_t c = 0; c < children.size(); ++c) {
            if (placed >> c & 1) continue;
            for (size_t s = 0; s < kWidth; ++s)
                if (child_of[s] < 0 && gain[c][s] > best) best = gain[c][s], best_child = c, best_slot = s;
        }
        child_of[best_slot] = int(best_child);
        placed |= 1u << best_child;
    }
    return child_of;
}

/// Writes trees one after the other.
class Encoder {
public:
    explicit Encoder(BvhData& data) : data_(data) {}

    /// `slack`: by how much boxes are made larger [m], for the rounding of rays from far away. Returns the levels.
    uint32_t append(std::span<const BinaryNode> nodes, std::span<const Primitive> primitives, float slack) {
        const WideChoice choice(nodes);
        struct Pending {
            uint32_t binary, wide, level;
        };
        std::vector<Pending> pending{{uint32_t(nodes.size() - 1), add_node(), 1}};
        uint32_t levels = 0;
        std::vector<uint32_t> children;
        for (size_t next = 0; next < pending.size(); ++next) {  // breadth first: the tops of trees lie together
            const auto [binary, wide, level] = pending[next];
            levels = std::max(levels, level);
            children.clear();
            choice.children(binary, children);
            Bounds3 boxes[kWidth], box;
            for (size_t i = 0; i < children.size(); ++i) {
                boxes[i] = nodes[children[i]].bounds;
                boxes[i].min -= slack;
                boxes[i].max += slack;
                box.extend(boxes[i]);
            }
            BvhNode node{};
            const Grid grid(box, node);
            const std::array<int, kWidth> child_of = assign_slots(box, {boxes, children.size()});
            node.nodes = static_cast<uint32_t>(data_.nodes.size());
            node.triangles = static_cast<uint32_t>(data_.triangles.size());
            for (uint32_t slot = 0; slot < kWidth; ++slot) {
                if (child_of[slot] < 0) continue;
                const uint32_t child = children[size_t(child_of[slot])];
                grid.quantise(boxes[child_of[slot]], slot, node);
                if (choice.is_leaf(child)) {
                    const auto first = static_cast<uint32_t>(data_.triangles.size()) - node.triangles;
                    set_byte(node.meta, slot, ((1u << nodes[child].primitives) - 1) << 5 | first);
                    append_primitives(child, nodes, primitives);
                } else {
                    set_byte(node.meta, slot, 1u << 5 | (24 + slot));
                    node.scales |= 1u << (24 + slot);
                    pending.push_back({child, add_node(), level + 1});
                }
            }
            data_.nodes[wide] = node;
        }
        return levels;
    }

    /// A tree without anything in it.
    void append_empty() { add_node(); }

private:
    static void set_byte(uint32_t (&words)[2], uint32_t i, uint32_t value) { words[i / 4] |= value << (8 * (i % 4)); }

    /// A node's own grid of 256 planes an axis.
    struct Grid {
        vec3 origin, spacing;

        Grid(const Bounds3& box, BvhNode& node) : origin(box.min) {
            for (int axis = 0; axis < 3; ++axis) {
                // One plane is kept for rounding up.
                int exponent;
                std::frexp((box.max[axis] - box.min[axis]) / 254.0f, &exponent);
                exponent = std::clamp(exponent, -126, 127);
                spacing[axis] = std::ldexp(1.0f, exponent);
                node.scales |= uint32_t(exponent + 127) << (8 * axis);
            }
            node.grid_origin = origin;
        }

        void quantise(const Bounds3& box, uint32_t slot, BvhNode& node) const {
            uint32_t(*low[3])[2] = {&node.low_x, &node.low_y, &node.low_z};
            uint32_t(*high[3])[2] = {&node.high_x, &node.high_y, &node.high_z};
            for (int axis = 0; axis < 3; ++axis) {
                const float lower = std::floor((box.min[axis] - origin[axis]) / spacing[axis]);
                const float upper = std::ceil((box.max[axis] - origin[axis]) / spacing[axis]);
                set_byte(*low[axis], slot, uint32_t(lower));
                set_byte(*high[axis], slot, uint32_t(upper));
            }
        }
    };

    uint32_t add_node() {
        data_.nodes.push_back({});
        return static_cast<uint32_t>(data_.nodes.size() - 1);
    }

    void append_primitives(uint32_t binary, std::span<const BinaryNode> nodes, std::span<const Primitive> primitives) {
        const BinaryNode& node = nodes[binary];
        if (node.primitives == 1) {
            data_.triangles.push_back(primitives[node.primitive].record);
            return;
        }
        for (const uint32_t child : node.children) append_primitives(child, nodes, primitives);
    }

    BvhData& data_;
};

uint32_t kind_of(const Scene& scene, const Mesh& mesh) {
    return scene.materials[mesh.material].alpha_mode == AlphaMode::Opaque ? BVH_OPAQUE : BVH_COVERED_IN_PART;
}

Primitive triangle_primitive(const vec3 (&corners)[3], uint32_t kind, uint32_t triangle, uint32_t instance) {
    Primitive primitive{{}, {{corners[0], corners[1], corners[2]}, kind, triangle, instance}};
    for (const vec3& p : corners) primitive.bounds.extend(p);
    return primitive;
}

Bounds3 bounds_of(std::span<const Primitive> primitives) {
    Bounds3 bounds;
    for (const Primitive& p : primitives) bounds.extend(p.bounds);
    return bounds;
}

/// Rays come from so far, in the space of the tree; the boxes must hold what triangle tests find in spite of rounding.
float slack_for(const Bounds3& bounds, float distance) {
    const vec3 largest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
    return 0x1p-21f * std::max({largest.x, largest.y, largest.z, distance});
}

mat4x3 inverse_of(const mat4x3& to_world) {
    const glm::dmat3 linear = glm::inverse(glm::dmat3(to_world[0], to_world[1], to_world[2]));
    return mat4x3(glm::dmat4x3(linear[0], linear[1], linear[2], -(linear * dvec3(to_world[3]))));
}

}  // namespace

bool has_two_levels(const Scene& scene, uint64_t most_copied_triangles) {
    return scene.needs.instances && scene.triangle_count > most_copied_triangles;
}

BvhData build_bvh(const Scene& scene, uint64_t most_copied_triangles) {
    const auto start = std::chrono::steady_clock::now();
    const std::unique_ptr<RTCDeviceTy, DeviceRelease> device(rtcNewDevice(nullptr));
    if (!device) throw Error(ErrorCode::Internal, "Embree does not start on this machine");
    BvhData data;
    Encoder encoder(data);
    data.two_levels = has_two_levels(scene, most_copied_triangles);

    const auto is_placed = [&](const Instance& instance) { return data.two_levels && !instance.identity; };
    std::vector<Primitive> primitives;
    std::vector<mat4x3> transforms;
    std::vector<float> ray_distance(scene.meshes.size(), -1.0f);  // by mesh that has a tree of its own
    const float scene_size = scene.bounds.empty() ? 0.0f : glm::length(scene.bounds.diagonal());
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.triangles.empty()) continue;
        if (!is_placed(instance)) {
            for (uint32_t k = 0; k < mesh.triangles.size(); ++k)
                primitives.push_back(triangle_primitive(world_triangle(scene, i, k).p, kind_of(scene, mesh), k, i));
            continue;
        }
        Bounds3 bounds;
        for (const uvec3& corner : mesh.triangles)
            for (int c = 0; c < 3; ++c) bounds.extend(instance.to_world * vec4(mesh.positions[corner[c]], 1));
        const auto place = static_cast<uint32_t>(transforms.size());
        primitives.push_back({bounds, {{}, BVH_INSTANCE, instance.mesh, i}});
        std::memcpy(&primitives.back().record.corners, &place, sizeof place);
        const mat4x3& from_world = transforms.emplace_back(inverse_of(instance.to_world));
        for (int axis = 0; axis < 3; ++axis)
            ray_distance[instance.mesh] =
                std::max(ray_distance[instance.mesh], scene_size * glm::length(from_world[axis]));
    }

    const auto append_tree = [&](float distance) {
        if (primitives.empty()) return encoder.append_empty(), 1u;
        const std::vector<BinaryNode> nodes = build_binary_tree(device.get(), primitives);
        return encoder.append(nodes, primitives, slack_for(bounds_of(primitives), distance));
    };
    const uint32_t top_levels = append_tree(scene_size);
    const size_t top_triangles = data.triangles.size();
    std::vector<uint32_t> roots(scene.meshes.size());
    uint32_t mesh_levels = 0;
    for (uint32_t m = 0; m < scene.meshes.size(); ++m) {
        if (ray_distance[m] < 0) continue;
        const Mesh& mesh = scene.meshes[m];
        primitives.clear();
        for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
            const uvec3 corner = mesh.triangles[k];
            primitives.push_back(
                triangle_primitive({mesh.positions[corner.x], mesh.positions[corner.y], mesh.positions[corner.z]},
                                   kind_of(scene, mesh), k, kNoHit));
        }
        roots[m] = static_cast<uint32_t>(data.nodes.size());
        mesh_levels = std::max(mesh_levels, append_tree(ray_distance[m]));
    }
    // Now that they are known: where meshes' trees begin, and where transforms lie, behind the triangles.
    const auto first_transform = static_cast<uint32_t>(data.triangles.size());
    for (size_t i = 0; i < top_triangles; ++i) {
        BvhTriangle& record = data.triangles[i];
        if (record.kind != BVH_INSTANCE) continue;
        record.triangle = roots[record.triangle];
        uint32_t place;
        std::memcpy(&place, &record.corners, sizeof place);
        place += first_transform;
        std::memcpy(&record.corners, &place, sizeof place);
    }
    for (const mat4x3& transform : transforms)
        std::memcpy(static_cast<void*>(&data.triangles.emplace_back()), &transform, sizeof transform);
    if (data.triangles.empty()) data.triangles.emplace_back();

    // A wide node's other children wait while one is visited; at an instance, its siblings and the node's children too.
    data.stack_entries = top_levels - 1 + (mesh_levels > 0 ? 1 + mesh_levels : 0);
    if (data.stack_entries > BVH_STACK)
        throw Error(ErrorCode::Unsupported, "the scene's ray structure needs a stack of " +
                                                std::to_string(data.stack_entries) + " entries; shaders have " +
                                                std::to_string(BVH_STACK));
    data.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return data;
}

}  // namespace photond::gpu
