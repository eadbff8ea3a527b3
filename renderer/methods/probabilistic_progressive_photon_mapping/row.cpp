// What the house asks of this method.

#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/progressive/progressive_mapping_gpu.h"
#include "renderer/progressive/progressive_row.h"

namespace photond {

MethodInfo probabilistic_progressive_photon_mapping_row();

MethodInfo probabilistic_progressive_photon_mapping_row() {
    MethodInfo info = progressive_row<ProbabilisticProgressivePhotonMapping,
                                      ProgressiveTwinGpu<ProbabilisticProgressivePhotonMapping>>();
    info.title = "Probabilistic progressive photon mapping";
    info.line =
        "Photon mapping averaged over passes whose radii shrink, each place's found by a pilot. Good at light through "
        "glass seen through glass; parts can be merged.";
    info.sources = {{"Knaus and Zwicker", 2011, "Progressive Photon Mapping: A Probabilistic Approach"},
                    {"Kaplanyan and Dachsbacher", 2013, "Adaptive Progressive Photon Mapping"}};
    return info;
}

}  // namespace photond
