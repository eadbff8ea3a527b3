#include "server/worker/helper_frames.h"

#include <vector>

#include "protocol/error.h"
#include "renderer/error/motion_errors.h"
#include "renderer/film/film_file.h"
#include "server/worker/film_layer.h"

namespace photond {

using nlohmann::json;

namespace {

/// Loads one layer of films that are of one size.
class FrameLayers {
public:
    FrameLayers(std::string layer, uint64_t memory_bytes) : layer_(std::move(layer)), memory_bytes_(memory_bytes) {}

    std::vector<float> load(const std::filesystem::path& path) {
        const uint64_t held = images_ * size_.pixels() * 3 * sizeof(float);
        if (held >= memory_bytes_)
            throw Error(ErrorCode::OutOfMemory, "frames of this size take more than the " +
                                                    std::to_string(memory_bytes_) + " bytes that the helper may hold");
        const Film film = FilmFile::load(path, memory_bytes_ - held).film;
        if (film.passes() == 0) throw Error(ErrorCode::Internal, "a film has no pass yet");
        if (images_++ == 0) size_ = film.size();
        if (film.size().width != size_.width || film.size().height != size_.height)
            throw Error(ErrorCode::Conflict, "the frames differ in size");
        return layer_ == "beauty" ? film.resolve_beauty() : film.resolve(film_layer(film, layer_).layer);
    }
    Size2 size() const { return size_; }

private:
    const std::string layer_;
    const uint64_t memory_bytes_;
    uint64_t images_ = 0;
    Size2 size_{};
};

struct MeasuredFrame {
    std::vector<float> image;
    CrossMeter references;

    static MeasuredFrame load(FrameLayers& layers, const MeasureFrameRequest::Films& films) {
        std::vector<float> image = layers.load(films.film);
        const std::vector<float> first = layers.load(films.first), second = layers.load(films.second);
        return {std::move(image), CrossMeter(layers.size(), first, second)};
    }
};

json figure(const std::optional<CrossError>& error) {
    return error ? json{{"value", error->value}, {"standard_error", error->standard_error}} : json();
}

}  // namespace

MeasureFrameReply measure_frame(const MeasureFrameRequest& asked, uint64_t memory_bytes) {
    FrameLayers layers(asked.layer, memory_bytes);
    const MeasuredFrame frame = MeasuredFrame::load(layers, asked.frame);
    MotionErrors motion;
    if (asked.before) {
        const MeasuredFrame before = MeasuredFrame::load(layers, *asked.before);
        motion = motion_errors(frame.references, before.references, frame.image, before.image);
    }
    return {{{"relative_mse", figure(frame.references.measure(frame.image).relative_mse)},
             {"flicker", figure(motion.flicker)},
             {"lag", figure(motion.lag)},
             {"change", figure(motion.change)}}};
}

}  // namespace photond
