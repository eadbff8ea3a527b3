// What the house asks of this method.

#include "renderer/methods/progressive_photon_mapping/progressive_photon_mapping.h"
#include "renderer/progressive/progressive_row.h"

namespace photond {

void ProgressivePhotonMappingParams::visit(ParamVisitor& visitor) {
    ProgressiveParams::visit(visitor);
    visitor.field("eye_samples", eye_samples,
                  {ParamGroup::Gathering, "", 1, 1024, "hit points a pixel, which passes take in turn"});
}

MethodInfo progressive_photon_mapping_row();

MethodInfo progressive_photon_mapping_row() {
    MethodInfo info = progressive_row<ProgressivePhotonMapping, void>();
    info.title = "Progressive photon mapping";
    info.line =
        "Photon mapping at fixed hit points with radii that shrink. Good at light through glass seen through glass; "
        "few samples a pixel.";
    info.sources = {{"Hachisuka, Ogaki and Jensen", 2008, "Progressive Photon Mapping"}};
    return info;
}

}  // namespace photond
