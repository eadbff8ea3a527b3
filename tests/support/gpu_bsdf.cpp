#include "tests/support/gpu_bsdf.h"

#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/transport/bsdf_albedo_table.h"

namespace photond::test {

namespace {

/// tests/gpu/bsdf.glsl's structs.
struct CaseRecord {
    vec3 geometric_normal, base_color;
    float metallic, roughness, ior, specular;
    vec3 specular_color;
    float transmission;
    uint32_t solid;
    float eta;
    BsdfPart part;
    float glossy_threshold;
    uint32_t mode;
};
struct SampleRecord {
    vec3 wi;
    Rgb weight;
    float pdf_sa;
    uint32_t delta, transmission, refraction;
    float eta;
};
static_assert(sizeof(CaseRecord) == 76 && sizeof(BsdfQuery) == 28 && sizeof(BsdfValue) == 16 &&
              sizeof(SampleRecord) == 44 && sizeof(BsdfTraits) == 40);

std::vector<CaseRecord> records_of(std::span<const BsdfCase> cases) {
    std::vector<CaseRecord> records;
    for (const BsdfCase& c : cases) {
        const Bsdf::Parameters& p = c.parameters;
        records.push_back({p.geometric_normal, p.base_color, p.metallic, p.roughness, p.ior, p.specular,
                           p.specular_color, p.transmission, p.solid, p.eta, c.part, c.glossy_threshold,
                           static_cast<uint32_t>(c.mode)});
    }
    return records;
}

PartOfScene albedo_tables() {
    const std::vector<vec2> table = AlbedoTable::get().device_data();
    return PartOfScene({{TABLES_BINDING, std::as_bytes(std::span(table))}});
}

}  // namespace

GpuBsdfs::GpuBsdfs()
    : tables_(albedo_tables()),
      evaluate_("tests/gpu/bsdf_evaluate.comp", &tables_.set()),
      sample_("tests/gpu/bsdf_sample.comp", &tables_.set()),
      traits_("tests/gpu/bsdf_traits.comp", &tables_.set()) {}

std::vector<BsdfValue> GpuBsdfs::evaluate(std::span<const BsdfCase> cases, std::span<const BsdfQuery> queries) const {
    return evaluate_.run<BsdfValue>(queries.size(), {{"cases", records_of(cases)}, {"queries", queries}});
}

std::vector<BsdfSample> GpuBsdfs::sample(std::span<const BsdfCase> cases, std::span<const BsdfQuery> queries) const {
    const auto records =
        sample_.run<SampleRecord>(queries.size(), {{"cases", records_of(cases)}, {"queries", queries}});
    std::vector<BsdfSample> samples;
    samples.reserve(records.size());
    for (const SampleRecord& r : records)
        samples.push_back({r.wi, r.weight, r.pdf_sa, r.delta != 0, r.transmission != 0, r.refraction != 0, r.eta});
    return samples;
}

std::vector<BsdfTraits> GpuBsdfs::traits(std::span<const BsdfCase> cases) const {
    return traits_.run<BsdfTraits>(cases.size(), {{"cases", records_of(cases)}});
}

}  // namespace photond::test
