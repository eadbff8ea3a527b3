// What the house asks of this method.

#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/progressive/progressive_mapping_gpu.h"
#include "renderer/progressive/progressive_row.h"

namespace photond {

MethodInfo stochastic_progressive_photon_mapping_row();

MethodInfo stochastic_progressive_photon_mapping_row() {
    MethodInfo info =
        progressive_row<StochasticProgressivePhotonMapping, ProgressiveTwinGpu<StochasticProgressivePhotonMapping>>();
    info.title = "Stochastic progressive photon mapping";
    info.line =
        "New hit points each pass, one radius a pixel that shrinks as photons come. Good at light through glass seen "
        "through glass, out of focus and in gloss.";
    info.sources = {{"Hachisuka and Jensen", 2009, "Stochastic Progressive Photon Mapping"},
                    {"Hachisuka, Ogaki and Jensen", 2008, "Progressive Photon Mapping"}};
    return info;
}

}  // namespace photond
