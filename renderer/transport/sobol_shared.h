// What sobol.glsl reads, for both compilers: the numbers of a pass, and the key of a sequence.
#ifndef PHOTOND_SOBOL_SHARED_H
#define PHOTOND_SOBOL_SHARED_H

#ifdef __cplusplus
#include <cstdint>
namespace photond::gpu {
using uint = uint32_t;
#endif

#define SAMPLER_KIND_SOBOL 0  // SamplerKind
#define SAMPLER_KIND_RANDOM 1
#define SOBOL_SETS_IN_BLOCK 10   // PassSampler::kSetsInBlock, and SequenceSampler::kSets
#define SOBOL_PREPARED_SETS 120  // PassSampler::kPreparedSets
#define SOBOL_DIMENSIONS 20
#define SOBOL_INDEX_BITS 32  // the generator matrices: a word for each dimension and bit of the index

/// PassSampler::SetPoint.
struct SobolSetPoint {
    uint x_reversed;
    uint y_reversed;
    uint64_t salt;
};

/// PassSampler, PassSampler::device_data(): the buffer at SAMPLER_BINDING.
struct PassSamplerData {
    uint kind;
    uint pass;
    uint set_salt;
    uint pixel_salt;
    uint64_t random_key;
    SobolSetPoint prepared[SOBOL_PREPARED_SETS];  // not read of independent numbers
};

/// SequenceSampler, SequenceSampler::device_key(): small enough for push constants.
struct SequenceKey {
    uint64_t key;
    uint kind;
    uint unused;  // the compilers differ in whether they would leave room here
};

#ifdef __cplusplus
static_assert(sizeof(PassSamplerData) == 24 + 16 * SOBOL_PREPARED_SETS && sizeof(SequenceKey) == 16,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
