#pragma once
// Photons scattered on the GPU at one place of a scene.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/transport/photon_scattering.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/leaning_triangle.h"

namespace photond::test {

/// In the layout tests/gpu/scatter_photon.comp reads.
struct ScatteringQuery {
    vec3 wi;
    vec3 numbers;   // u_lobe, u
    vec3 outgoing;  // to ask the density of
};

struct ScatteringAnswer {
    PhotonScattering scattering;
    Rgb density;
    float pdf_sa;  // of it
};

class GpuPhotonScattering {
public:
    /// Of a finished scene, which is borrowed.
    explicit GpuPhotonScattering(const Scene& scene)
        : scene_(gpu_device(), scene), twin_("tests/gpu/scatter_photon.comp", &scene_.set(), scene_.specialization()) {}

    std::vector<ScatteringAnswer> scatter(const Hit& hit, PartOf part, float outside_ior,
                                          std::span<const ScatteringQuery> queries) const {
        struct Place {
            Hit hit;
            float outside_ior;
            PartOf part;
            float glossy_threshold;
        };
        struct Answer {
            vec3 direction;
            Rgb weight;
            float pdf_sa;
            uint32_t delta, refraction;
            Rgb density;
            float density_pdf_sa;
        };
        static_assert(sizeof(Place) == 32 && sizeof(Answer) == 52 && sizeof(ScatteringQuery) == 36);
        const std::vector place{Place{hit, outside_ior, part, kThreshold}};
        std::vector<ScatteringAnswer> answers;
        for (const Answer& a : twin_.run<Answer>(queries.size(), {{"place", place}, {"queries", queries}}))
            answers.push_back(
                {{a.direction, a.weight, a.pdf_sa, a.delta != 0, a.refraction != 0}, a.density, a.density_pdf_sa});
        return answers;
    }

private:
    gpu::DeviceScene scene_;
    Twin twin_;
};

}  // namespace photond::test
