#pragma once
// Which lights a point asks for V where it does not ask a subset that others share: a few for each point, drawn in
// proportion to what they may bring there. GPU twin: vpl_choice_gpu.h.
//
// Whatever a light is chosen by, what it brings counts over the number of times that it is chosen in the mean; V is not
// looked at before. So the sum over all lights is the mean of what comes out, whoever answers for V, as long as every
// light that brings something can be chosen: how well the choice fits shows in the noise alone.

#include <memory>

#include "renderer/many_lights/vpl_lighting.h"
#include "renderer/many_lights/vpl_tree.h"

namespace photond {

/// kLanes points that lights are chosen for, near each other where they can be.
struct ChoicePoints {
    VplReceivers receivers;
    uint32_t key[kLanes];               // of their random numbers; read of points that are there
    uint32_t most_scatterings[kLanes];  // of a light that counts
    bool general[kLanes];               // not Lambert
};

/// A way to choose. assign() comes once a pass, then any number of threads.
class VplChooser {
public:
    virtual ~VplChooser() = default;
    virtual void assign(std::span<const Vpl> vpls) = 0;

    /// What a thread keeps.
    struct Scratch {
        struct Node {
            float bound;
            uint32_t index;
        };
        std::vector<Node> heap;
        std::vector<uint32_t> cut;
        std::vector<float> sums;
        std::vector<ChosenVpl> chosen[kLanes];  // what choose() leaves: of each point
    };
    virtual void choose(const ChoicePoints& points, float clamp_sq_m2, Scratch& scratch) const = 0;
    virtual uint64_t bytes() const = 0;
};

/// Looks at what every light would bring unshadowed, and draws `count` in proportion: at equal steps of the running sum
/// with one random start, so that a light of n steps is drawn n times, and lights of one kind mostly once in a while.
/// [Talbot et al. 2005] Importance Resampling for Global Illumination. EGSR. [Madow 1949] On the Theory of Systematic
/// Sampling, II. Ann. Math. Stat. 20(3).
///
/// Lights that are not Lambert, and points that are not, are taken for about that: the cosine at the light for 1, that
/// at the point for at least a quarter.
class ResampledVpls final : public VplChooser {
public:
    explicit ResampledVpls(uint32_t count) : count_(count) {}
    void assign(std::span<const Vpl> vpls) override;
    void choose(const ChoicePoints& points, float clamp_sq_m2, Scratch& scratch) const override;
    uint64_t bytes() const override { return blocks_.capacity() * sizeof(Block); }

private:
    /// kLanes lights.
    struct Block {
        Vec3Array position, normal;
        alignas(kLaneAlignment) LaneFloats size;          // vpl_size(); 0 past the last light
        alignas(kLaneAlignment) LaneFloats least_cosine;  // 0 of Lambert lights, 1 of others
        alignas(kLaneAlignment) LaneFloats scatterings;
    };
    struct Receiver;
    static FloatLanes sizes(const Block& block, const Receiver& to);

    const uint32_t count_;
    std::vector<Block> blocks_;
};

/// Groups the lights for each point: from the root of a tree, always what may bring most is parted in two, until there
/// are `cut_size` nodes or nothing is left to part; nodes that can bring nothing are left out. Of each node one light
/// is drawn in proportion to its size, by a walk down the tree.
///
/// The points of a call go by one cut, by the sum of what nodes may bring to each: neighbours in the image nearly
/// agree, and draw their lights apart. [Walter et al. 2005] Lightcuts: A Scalable Approach to Illumination. ACM TOG
/// 24(3). [Yuksel 2019] Stochastic Lightcuts. HPG. [Lin and Yuksel 2020] Real-Time Stochastic Lightcuts: cuts that
/// neighbours share.
class LightcutVpls final : public VplChooser {
public:
    explicit LightcutVpls(uint32_t cut_size) : cut_size_(cut_size) {}
    void assign(std::span<const Vpl> vpls) override { tree_.build(vpls); }
    void choose(const ChoicePoints& points, float clamp_sq_m2, Scratch& scratch) const override;
    uint64_t bytes() const override { return tree_.bytes(); }
    const VplTree& tree() const { return tree_; }

private:
    void find_cut(const VplReceivers& receivers, float clamp_sq_m2, Scratch& scratch) const;

    const uint32_t cut_size_;
    VplTree tree_;
};

/// VplLighting::light() with the lights of a chooser that was assigned pass.set, of all points [first, end) alike; the
/// pass's subsets are not looked at.
void light_by_choice(const VplChooser& chooser, const VplPass& pass, const GBuffer& buffer, uint32_t first,
                     uint32_t end, std::span<Rgb> sums, VplLighting& lighting, VplChooser::Scratch& scratch,
                     Counts& counts);

}  // namespace photond
