#pragma once
// A binary tree over virtual point lights, and the most that a node's lights together can bring to a point.
//
// Lights are sorted along a Morton curve of position and normal; above them stands a perfect tree, whose leaves past
// the last light hold nothing. So a tree is made in time linear in the lights but for the sort, level by level, the
// same on both devices (vpl_tree_gpu.h).
//
// [Walter et al. 2005] Lightcuts: A Scalable Approach to Illumination. ACM TOG 24(3): the bound. [Lin and Yuksel 2020]
// Real-Time Stochastic Lightcuts. Proc. ACM Comput. Graph. Interact. Tech. 3(1): the perfect tree.

#include <span>
#include <vector>

#include "renderer/core/lanes.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/many_lights/vpl_tree_shared.h"

namespace photond {

using gpu::VplTreeNode;

/// What no direction gets more of, in its greatest channel [W/sr]. Of lights that are not Lambert: a Lambert
/// reflector's of albedo 1, for want of a bound; what goes by it may be noisy there, and must not take it for one.
/// Where lights say what choices take them for (Vpl::choice), that share of it.
inline float vpl_size(const Vpl& vpl) {
    const float most = max_component(vpl.intensity) * (is_lambert(vpl) ? std::max(vpl.correction, 1.0f) : kInvPi);
    return vpl.choice > 0 ? vpl.choice * most : most;
}

/// The number of leaves above so many lights.
uint32_t vpl_tree_leaves(uint32_t lights);
/// Where a light comes along the curve: VPL_KEY_BITS bits. `low` and `scale`: vpl_key_scale() of the lights' box.
uint32_t vpl_key(const Vpl& vpl, const vec3& low, float scale);
/// The greatest power of two that keeps a box of that extent within the key's cells.
float vpl_key_scale(const vec3& extent);
VplTreeNode vpl_leaf(const Vpl& vpl, uint32_t light);
VplTreeNode merge_vpl_nodes(const VplTreeNode& a, const VplTreeNode& b);

class VplTree {
public:
    void build(std::span<const Vpl> vpls);

    /// nodes()[VPL_TREE_ROOT] is the root and is there without lights too; nodes()[0] is nothing. Those from leaves()
    /// on are leaves.
    std::span<const VplTreeNode> nodes() const { return nodes_; }
    uint32_t leaves() const { return leaves_; }
    uint64_t bytes() const { return nodes_.capacity() * sizeof(VplTreeNode) + keys_.capacity() * sizeof(uint64_t); }

private:
    std::vector<VplTreeNode> nodes_;
    std::vector<uint64_t> keys_;  // above the lights' numbers
    uint32_t leaves_ = 0;
};

/// kLanes points that lights are chosen for.
struct VplReceivers {
    Vec3Lanes position;  // world [m]
    Vec3Lanes normal;    // that shades, unit; 0 where light from all sides counts
    FloatLanes there;    // 1, or 0 where there is no point
};

/// The most irradiance [W m^-2] that a node of Lambert lights can bring to each point, in the lights' greatest channel
/// and unshadowed, with connections clamped at B = `clamp_sq_m2`; a true bound but for rounding. 0 only where nothing
/// can come; below infinity always. [Walter et al. 2005, sec. 3.3]; the cosines are bounded tighter, see max_cosine().
FloatLanes vpl_bound(const VplTreeNode& node, const VplReceivers& points, float clamp_sq_m2);

}  // namespace photond
