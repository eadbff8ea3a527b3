// The GLSL twins of the samplers: the same numbers, bit for bit.

#include <gtest/gtest.h>

#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/transport/sobol.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_twins_sobol_test {
namespace {

using namespace test;

struct Element {
    uint64_t index;
    uint32_t pixel;
    uint32_t set;
};

TEST(GpuTwinsSobol, SamplersAreTheSameNumbers) {
    const PartOfScene scene{{SOBOL_BINDING, std::as_bytes(sobol_directions())}};
    const Twin twin("tests/gpu/sobol.comp", &scene.set());
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<Element> elements(4000);
    for (size_t i = 0; i < elements.size(); ++i) {
        Element& e = elements[i];
        e.pixel = random.next_bits() >> (random.next_bits() % 32);
        e.index = (uint64_t{random.next_bits()} << 32 | random.next_bits()) >> (random.next_bits() % 64);
        // The sets of the first block, those prepared, and those past them.
        e.set = random.next_bits() % (i % 2 == 0 ? PassSampler::kSetsInBlock : 3 * PassSampler::kPreparedSets);
    }
    for (const SamplerKind kind : {SamplerKind::Sobol, SamplerKind::Random})
        for (const uint32_t pass : {0u, 1u, 77u, 0xffff'fff0u}) {
            const PassSampler sampler(kind, 0x1234'5678'9abc'def0ull, RandomDomain::Camera, pass);
            const SequenceSampler sequence(kind, 0x1234'5678'9abc'def0ull, RandomDomain::Photons, pass);
            const std::vector data{sampler.device_data()};
            const std::vector key{sequence.device_key()};
            const auto points = twin.run<vec2>(2 * elements.size(),
                                               {{"pass_sampler", data}, {"sequence", key}, {"elements", elements}});
            size_t equal = 0;
            for (size_t i = 0; i < elements.size(); ++i) {
                const Element& e = elements[i];
                equal += points[2 * i] == sampler.sample_2d(sampler.pixel_key(e.pixel), e.set);
                equal += points[2 * i + 1] == sequence.sample_2d(e.index, e.set);
            }
            EXPECT_EQ(equal, points.size()) << "kind " << int(kind) << ", pass " << pass;
        }
}

}  // namespace
}  // namespace photond::gpu_twins_sobol_test
