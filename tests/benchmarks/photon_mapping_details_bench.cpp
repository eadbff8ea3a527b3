// Photon mapping's clipped discs in furnished places: bias of the indirect light over the whole image and in its worst
// row, against path tracing, with whole discs beside it.
//
// Usage: photon_mapping_details_bench [passes of the reference] [scene ...]

#include <cstdio>
#include <cstdlib>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"

namespace photond {
namespace {

constexpr Size2 kSize{128, 96};

std::vector<double> row_means(const Film& film) {
    const std::vector<float> values = film.resolve(Layer::Indirect);
    std::vector<double> rows(kSize.height, 0.0);
    for (size_t i = 0; i < values.size(); ++i) rows[i / (size_t{3} * kSize.width)] += double{values[i]};
    return rows;
}

struct Error {
    double mean, worst;
    size_t row;
};

Error error_of(const std::vector<double>& rows, const std::vector<double>& truth) {
    Error error{0, 0, 0};
    double sum = 0, all = 0;
    for (size_t i = 0; i < rows.size(); ++i) {
        sum += rows[i], all += truth[i];
        const double off = rows[i] / truth[i] - 1;
        if (std::abs(off) > std::abs(error.worst)) error.worst = off, error.row = i;
    }
    error.mean = sum / all - 1;
    return error;
}

void measure(std::string_view name, uint32_t passes) {
    const Scene scene = make_builtin_scene(name);
    test::RenderSettings path_tracing;
    path_tracing.size = kSize;
    path_tracing.passes = passes;
    path_tracing.seed = 7;
    const std::vector<double> truth = row_means(test::render(scene, path_tracing));
    struct Variant {
        const char* name;
        DiscBoundary boundary;
        bool precomputed;
    };
    constexpr Variant kVariants[] = {{"whole", DiscBoundary::None, false},
                                     {"clipped", DiscBoundary::Clip, false},
                                     {"clipped, precomputed", DiscBoundary::Clip, true}};
    for (const Gather gather : {Gather::Direct, Gather::Final})
        for (const uint32_t photons : {10'000u, 200'000u}) {
            std::printf("%-28s %-6s %6u photons:", std::string(name).c_str(),
                        gather == Gather::Direct ? "direct" : "final", photons);
            double whole_seconds = 0;
            for (const Variant& variant : kVariants) {
                if (variant.precomputed && gather == Gather::Direct) continue;
                test::RenderSettingsOf<PhotonMapping> settings;
                settings.size = kSize;
                settings.passes = gather == Gather::Direct ? 64 : 16;
                settings.params.gather = gather;
                settings.params.photons = photons;
                settings.params.boundary = variant.boundary;
                settings.params.precompute_irradiance = variant.precomputed;
                const double start = cpu_now_seconds();
                const Error error = error_of(row_means(test::render(scene, settings)), truth);
                const double seconds = cpu_now_seconds() - start;
                if (whole_seconds == 0) whole_seconds = seconds;
                std::printf("  %s mean %+6.2f %%, worst row %+7.2f %% (%zu), %.1f s (%.2f)", variant.name,
                            100 * error.mean, 100 * error.worst, error.row, seconds, seconds / whole_seconds);
            }
            std::printf("\n"), std::fflush(stdout);
        }
}

}  // namespace
}  // namespace photond

int main(int count, char** arguments) {
    using namespace photond;
    const uint32_t passes = count > 1 ? static_cast<uint32_t>(std::atoi(arguments[1])) : 1024;
    if (count > 2)
        for (int i = 2; i < count; ++i) measure(arguments[i], passes);
    else
        for (const std::string_view name : builtin_scene_names("details")) measure(name, passes);
}
