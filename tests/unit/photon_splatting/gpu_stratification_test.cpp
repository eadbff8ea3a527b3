// Stratified photons on a GPU against stratify(): the same sources, in its order.

#include "renderer/methods/photon_splatting/stratification_gpu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/support/gpu_twin.h"

namespace photond::gpu_stratification_test {
namespace {

constexpr uint64_t kSeed = 4;
constexpr uint32_t kPass = 2;

StratificationSettings settings_of(uint32_t cells, Representative representative, uint32_t splats_per_cell = 1) {
    StratificationSettings settings;
    settings.bounds = {vec3(-1, 0, 2), vec3(7, 5, 6)};
    settings.cells = cells;
    settings.minimum_photons = 1;
    settings.splats_per_cell = splats_per_cell;
    settings.representative = representative;
    return settings;
}

/// Crowded towards a corner, some without power, some outside; powers over three orders of magnitude. None so near to
/// the border of a cell of `grid` that rounding could take it to another.
std::vector<ReflectedPhoton> photons_in(const StratificationSettings& settings, size_t count) {
    const StratificationGrid grid(settings, kSeed, kPass);
    RandomStream random(count, RandomDomain::Test, 0, 0);
    const auto number = [&] { return random.next(); };
    std::vector<ReflectedPhoton> photons;
    while (photons.size() < count) {
        ReflectedPhoton photon;
        const vec3 u(number(), number(), number());
        photon.position = settings.bounds.min + settings.bounds.diagonal() * u * u * 1.01f;
        photon.power_w = number() < 0.05f ? Rgb(0) : std::exp(7 * number()) * Rgb(number(), number(), number());
        photon.direction = glm::normalize(vec3(number(), number(), number()) + 0.01f);
        const vec3 place = (photon.position - grid.min) * grid.cells_per_m + grid.first;
        const vec3 from_border = glm::abs(place - glm::round(place));
        if (std::min({from_border.x, from_border.y, from_border.z}) < 1e-3f) continue;
        if (number() < 0.02f) photon.position.y += 20;
        if (number() < 0.01f) photon.position.x = std::nanf("");
        photons.push_back(photon);
    }
    return photons;
}

/// On the device they lie the other way round.
std::vector<SplatSource> on_device(StratificationGpu& stratification, std::vector<ReflectedPhoton> photons,
                                   uint32_t pass = kPass) {
    gpu::Device& device = test::gpu_device();
    std::vector<uint32_t> order(photons.size());
    std::iota(order.rbegin(), order.rend(), 0u);
    std::reverse(photons.begin(), photons.end());
    gpu::Buffer records = gpu::make_buffer(device, "test photons", std::span<const ReflectedPhoton>(photons));
    gpu::Buffer orders = gpu::make_buffer(device, "test order", std::span<const uint32_t>(order));
    stratification.start(kSeed, pass, static_cast<uint32_t>(photons.size()));
    gpu::CommandList commands(device);
    stratification.record(commands, records, orders);
    commands.submit();
    commands.wait();
    if (stratification.sources_of_pass() == 0) return {};
    return gpu::read_back<SplatSource>(device, stratification.sources(), stratification.sources_of_pass());
}

std::vector<SplatSource> on_host(std::span<const ReflectedPhoton> photons, const StratificationSettings& settings) {
    uint64_t peak_bytes = 0;
    return stratify(photons, settings, kSeed, kPass, peak_bytes);
}

/// The number of sources of one that are not the other's, or in another order, or with another power.
size_t differing(const std::vector<SplatSource>& gpu, const std::vector<SplatSource>& cpu) {
    EXPECT_EQ(gpu.size(), cpu.size());
    size_t differing = 0;
    for (size_t i = 0; i < std::min(gpu.size(), cpu.size()); ++i) {
        const vec3 difference = glm::abs(gpu[i].power_w - cpu[i].power_w);
        const bool alike = gpu[i].photon == cpu[i].photon && std::fabs(gpu[i].photons / cpu[i].photons - 1) < 1e-6f &&
                           max_component(difference) <= 1e-6f * max_component(cpu[i].power_w);
        differing += alike ? 0 : 1;
    }
    return differing;
}

class GpuStratification : public testing::TestWithParam<Representative> {};

TEST_P(GpuStratification, ChoosesThePhotonsOfTheCpu) {
    struct Case {
        uint32_t cells, minimum_photons, splats;
        bool mean_power = false;
    };
    for (const Case& c :
         {Case{1, 1, 1}, Case{30, 1, 4}, Case{30, 3, 1}, Case{30, 40, 4, true}, Case{1024, 1, 1}, Case{1024, 3, 2}}) {
        StratificationSettings settings = settings_of(c.cells, GetParam(), c.splats);
        settings.minimum_photons = c.minimum_photons;
        settings.mean_power = c.mean_power;
        StratificationGpu stratification(test::gpu_device(), settings);
        const std::vector<ReflectedPhoton> photons = photons_in(settings, 9000);
        const std::vector<SplatSource> cpu = on_host(photons, settings);
        EXPECT_GE(cpu.size(), 100u) << "those outside";
        // Positions and directions are compared as floats: of two about as near either may be chosen.
        const bool of_floats =
            GetParam() == Representative::ClosestToMean || GetParam() == Representative::DominantDirection;
        EXPECT_LE(differing(on_device(stratification, photons), cpu), of_floats ? 2u : 0u)
            << c.cells << " cells, at least " << c.minimum_photons << " photons, " << c.splats << " splats";
    }
}
INSTANTIATE_TEST_SUITE_P(Representatives, GpuStratification,
                         testing::Values(Representative::Random, Representative::ByPower, Representative::ClosestToMean,
                                         Representative::DominantDirection));

TEST(GpuStratification, AnyNumberOfPhotonsOneAfterAnother) {
    StratificationSettings settings = settings_of(20, Representative::ByPower);
    settings.minimum_photons = 2;
    StratificationGpu stratification(test::gpu_device(), settings);
    for (const size_t count : {1000u, 0u, 1u, 2u, 70u, 30'000u, 500u}) {
        const std::vector<ReflectedPhoton> photons = photons_in(settings, count);
        EXPECT_EQ(differing(on_device(stratification, photons), on_host(photons, settings)), 0u) << count;
    }
    std::vector<ReflectedPhoton> black(100);
    EXPECT_TRUE(on_device(stratification, black).empty());
}

TEST(GpuStratification, PassesShiftTheGrid) {
    const StratificationSettings settings = settings_of(20, Representative::Random);
    StratificationGpu stratification(test::gpu_device(), settings);
    const std::vector<ReflectedPhoton> photons = photons_in(settings, 3000);
    const std::vector<SplatSource> one = on_device(stratification, photons),
                                   other = on_device(stratification, photons, 3);
    EXPECT_GT(one.size(), 500u);
    EXPECT_TRUE(one.size() != other.size() || differing(one, other) > 100);
    EXPECT_EQ(differing(on_device(stratification, photons), one), 0u) << "the same every time";
}

TEST(GpuStratification, OneCellOfPowersOfAllMagnitudes) {
    StratificationSettings settings = settings_of(4, Representative::ByPower, 3);
    settings.minimum_photons = 1'000'000;
    for (const Representative representative :
         {Representative::Random, Representative::ByPower, Representative::ClosestToMean}) {
        settings.representative = representative;
        StratificationGpu stratification(test::gpu_device(), settings);
        std::vector<ReflectedPhoton> photons = photons_in(settings, 10'000);
        RandomStream random(1, RandomDomain::Test, 0, 0);
        for (ReflectedPhoton& photon : photons) photon.power_w *= std::exp(160 * random.next() - 80);
        for (const SplatSource& source : on_device(stratification, photons)) ASSERT_TRUE(is_finite(source.power_w));
        EXPECT_LE(differing(on_device(stratification, photons), on_host(photons, settings)),
                  representative == Representative::ClosestToMean ? 1u : 0u);
    }
}

TEST(GpuStratification, ItsMemoryIsWhatItSays) {
    gpu::Device& device = test::gpu_device();
    const auto structures = device.memory().structures();
    const auto bytes_before = std::accumulate(structures.begin(), structures.end(), uint64_t{0},
                                              [](uint64_t sum, const auto& one) { return sum + one.second; });
    for (const uint32_t minimum : {1u, 2u}) {
        StratificationSettings settings = settings_of(20, Representative::Random);
        settings.minimum_photons = minimum;
        StratificationGpu stratification(device, settings);
        stratification.start(kSeed, kPass, 1'000'000);
        uint64_t bytes = 0;
        for (const auto& [name, held] : device.memory().structures()) bytes += held;
        const double said = double(StratificationGpu::device_bytes(1'000'000, minimum));
        EXPECT_NEAR(double(bytes - bytes_before), said, 0.03 * said);
    }
    EXPECT_EQ(device.memory().structures(), structures);
}

}  // namespace
}  // namespace photond::gpu_stratification_test
