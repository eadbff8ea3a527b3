#include "renderer/eye/eye_constants.h"

#include "renderer/eye/pixel_filter.h"

namespace photond {

gpu::EyeConstants make_eye_constants(const View& view, uint32_t max_scatterings, uint32_t roulette_start) {
    static_assert(FILTER_BINS == PixelFilterSampler::kBins && FILTER_RADIUS == PixelFilterSampler::kRadius);
    const CameraRays rays(view.camera, view.film_size);
    const Camera& camera = rays.camera();
    const PixelFilterSampler filter(view.filter);
    gpu::EyeConstants eye{};
    eye.camera.corner = rays.corner();
    eye.camera.pixel_x = rays.pixel_x();
    eye.camera.pixel_y = rays.pixel_y();
    eye.width = view.film_size.width;
    eye.height = view.film_size.height;
    eye.camera.orthographic = camera.orthographic;
    eye.camera.position = camera.position;
    eye.camera.aperture_radius_m = camera.aperture_radius_m;
    eye.camera.forward = camera.forward;
    eye.camera.focus_distance_m = camera.focus_distance_m;
    eye.camera.right = camera.right;
    eye.camera.up = camera.up;
    eye.smooth_filter = view.filter != PixelFilter::Box;
    eye.max_scatterings = max_scatterings;
    eye.roulette_start = roulette_start;
    std::ranges::copy(filter.cdf(), eye.filter_cdf);
    return eye;
}

}  // namespace photond
