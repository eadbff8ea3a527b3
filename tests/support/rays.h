#pragma once
// The ray structure of a scene, for tests that only need rays.

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/memory_budget.h"

namespace photond::test {

/// Of a finished scene, which must outlive it.
inline std::unique_ptr<Intersector> intersector_of(const Scene& scene) {
    MemoryBudget budget;
    Stats stats;
    return make_embree_intersector(scene, budget, stats);
}

}  // namespace photond::test
