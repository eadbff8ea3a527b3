// What placements of virtual lights are worth on the CPU, and visibility by voxels near the point: processor seconds a
// pass, relative variance of a pass, efficiency (one over their product, in proportion to the first row's of the
// scene), and the relative squared bias against the mean of all unbiased rows.
//
// Arguments: scenes, else a room lit through its door, the Cornell box, and a furnished room.

#include <cstdio>
#include <string>

#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/render.h"

namespace photond {
namespace {

constexpr uint32_t kRuns = 10, kPasses = 2;

struct Row {
    std::string name;
    SvoManyLightsParams params;
    bool biased = false;
    std::vector<std::vector<float>> images{};  // of the runs: indirect light
    double cpu_seconds = 0;                    // a pass
    Counts counts{};
};

std::vector<Row> rows() {
    std::vector<Row> all;
    const auto add = [&](std::string name, auto change, bool biased = false) {
        Row& row = all.emplace_back(Row{.name = std::move(name), .params = {}, .biased = biased});
        change(row.params);
    };
    for (const auto& [choice, by] :
         {std::pair(VplChoice::Resampled, "resampled"), {VplChoice::Interleaved, "interleaved"}})
        for (const auto& [placement, word] : {std::pair(VplPlacement::Flux, "flux"),
                                              {VplPlacement::Camera, "camera"},
                                              {VplPlacement::Acceptance, "acceptance"},
                                              {VplPlacement::Metropolis, "metropolis"}})
            add(std::string(by) + " " + word,
                [&](SvoManyLightsParams& p) { p.vpl_choice = choice, p.placement = placement; });
    add(
        "camera by voxels",
        [](SvoManyLightsParams& p) { p.placement = VplPlacement::Camera, p.visibility = VplVisibility::Svo; }, true);
    add(
        "svo", [](SvoManyLightsParams& p) { p.visibility = VplVisibility::Svo; }, true);
    add(
        "svo interleaved",
        [](SvoManyLightsParams& p) { p.visibility = VplVisibility::Svo, p.vpl_choice = VplChoice::Interleaved; }, true);
    add(
        "near_field 0.4 interleaved",
        [](SvoManyLightsParams& p) {
            p.visibility = VplVisibility::NearField, p.vpl_choice = VplChoice::Interleaved,
            p.near_field_radius_m = 0.4f;
        },
        true);
    add(
        "none", [](SvoManyLightsParams& p) { p.visibility = VplVisibility::None; }, true);
    for (const double share : {0.1, 0.2, 0.4, 0.8})
        add(
            "near_field " + std::to_string(share),
            [&](SvoManyLightsParams& p) {
                p.visibility = VplVisibility::NearField;
                p.near_field_radius_m = static_cast<float>(share);  // of the scene's radius
            },
            true);
    return all;
}

void measure(const std::string& name) {
    const Scene scene = make_builtin_scene(name);
    MemoryBudget budget;
    Stats unused;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, unused);
    std::vector<Row> all = rows();
    for (uint32_t run = 0; run < kRuns; ++run)
        for (Row& row : all) {
            test::RenderSettingsOf<SvoManyLights> settings;
            settings.size = {128, 96};
            settings.seed = 100 + run;
            settings.params = row.params;
            if (settings.params.near_field_radius_m) *settings.params.near_field_radius_m *= scene.bounds.radius();
            Film film(settings.size, settings.layers);
            Stats stats;
            MemoryBudget own;
            const RenderContext context{scene, intersector.get(), test::view_of(scene, settings), settings.seed, own};
            SvoManyLights method(settings.params);
            method.begin(context, stats);
            const double before = cpu_now_seconds();
            for (uint32_t pass = 0; pass < kPasses; ++pass) {
                method.run_pass(pass, stats, CancelToken{});
                method.resolve(film);
            }
            row.cpu_seconds += (cpu_now_seconds() - before) / (kRuns * kPasses);
            row.counts += stats.counts;
            row.images.push_back(film.resolve(Layer::Indirect));
        }
    const size_t values = all[0].images[0].size();
    std::vector<double> reference(values);
    double mean = 0, unbiased = 0;
    for (const Row& row : all) unbiased += row.biased ? 0 : kRuns;
    for (size_t i = 0; i < values; ++i) {
        for (const Row& row : all)
            for (const std::vector<float>& image : row.images)
                if (!row.biased) reference[i] += double{image[i]} / unbiased;
        mean += reference[i] / double(values);
    }
    double first = 0;
    for (const Row& row : all) {
        double variance = 0, bias = 0, image_mean = 0;
        for (size_t i = 0; i < values; ++i) {
            double sum = 0, squares = 0;
            for (const std::vector<float>& image : row.images)
                sum += double{image[i]}, squares += double{image[i]} * double{image[i]};
            const double own = sum / kRuns, spread = (squares - sum * own) / (kRuns - 1);
            const double over = reference[i] * reference[i] + 0.01 * mean * mean;
            variance += spread / over / double(values);
            bias += ((own - reference[i]) * (own - reference[i]) - spread / kRuns) / over / double(values);
            image_mean += own / double(values);
        }
        const double efficiency = 1 / (variance * kPasses * row.cpu_seconds);
        if (first == 0) first = efficiency;
        std::printf("%-20s %-24s %8.4f s  variance %8.4f  efficiency %6.3f  bias^2 %8.5f  mean %+6.2f %%", name.c_str(),
                    row.name.c_str(), row.cpu_seconds, variance * kPasses, efficiency / first, bias,
                    100 * (image_mean / mean - 1));
        if (row.counts.vpls_offered > 0)
            std::printf(
                "  accepted %llu of %llu, %.0f lights", static_cast<unsigned long long>(row.counts.vpls_accepted),
                static_cast<unsigned long long>(row.counts.vpls_offered), double(row.counts.vpls) / (kRuns * kPasses));
        std::printf("\n");
        std::fflush(stdout);
    }
}

}  // namespace
}  // namespace photond

int main(int count, char** arguments) {
    using namespace photond;
    std::vector<std::string> scenes(arguments + 1, arguments + count);
    if (scenes.empty()) scenes = {"doors/ajar", "cornell-box", "interior"};
    for (const std::string& scene : scenes) measure(scene);
}
