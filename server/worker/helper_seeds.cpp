#include "server/worker/helper_seeds.h"

#include <algorithm>

#include "protocol/error.h"
#include "renderer/error/cross_meter.h"
#include "renderer/error/seed_errors.h"
#include "renderer/error/welch_map.h"
#include "renderer/error/welch_picture.h"
#include "renderer/film/film_file.h"
#include "renderer/film/png_file.h"
#include "server/worker/film_layer.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr uint64_t kPixelBytes = 3 * sizeof(float);

/// One layer of every film: those of the method, then the reference's two. Without a value where one has no such layer.
class LayerOfFilms {
public:
    LayerOfFilms(const MeasureSeedsRequest& asked, const std::string& layer, uint64_t memory_bytes) {
        std::vector<std::filesystem::path> paths = asked.films;
        for (const auto* source : {&asked.reference.first, &*asked.reference.second}) paths.push_back(source->path());
        for (const std::filesystem::path& path : paths) {
            const uint64_t held = images_.size() * size_.pixels() * kPixelBytes;
            const Film film = FilmFile::load(path, memory_bytes - std::min(memory_bytes, held)).film;
            if (film.passes() == 0) throw Error(ErrorCode::Internal, "a film has no pass yet");
            if (images_.empty()) size_ = film.size();
            if (film.size().width != size_.width || film.size().height != size_.height)
                throw Error(ErrorCode::Conflict, "/films", "the films differ in size");
            // R, half of U - V, their weights and the films' mean come on top.
            const uint64_t needed = (paths.size() + 4) * size_.pixels() * kPixelBytes;
            if (needed > memory_bytes)
                throw Error(ErrorCode::OutOfMemory, std::to_string(paths.size()) + " films of this size take " +
                                                        std::to_string(needed) + " bytes, more than the " +
                                                        std::to_string(memory_bytes) + " that the helper may hold");
            const bool beauty = layer == LayerMetric().layer;
            const LayerInfo* info = beauty ? nullptr : find_layer(layer);
            missing_ = missing_ || (!beauty && !(info && film.layers().has(info->layer)));
            if (missing_) return;
            images_.push_back(beauty ? film.resolve_beauty() : film.resolve(info->layer));
        }
        references_.emplace(size_, images_.end()[-2], images_.end()[-1]);
        images_.resize(images_.size() - 2);
    }

    bool missing() const { return missing_; }
    json measured() const { return {{"errors", errors_json()}, {"map", map_json()}}; }

private:
    json errors_json() const {
        const SeedErrors errors = seed_errors(*references_, images_);
        json by_metric = json::object();
        for (const MetricInfo& info : kMetrics) {
            if (!is_quadratic(info.metric) || mean_square_of(info.metric) != info.metric) continue;
            const std::optional<SeedError>& error = errors.of(info.metric);
            if (!error) continue;
            const std::optional<Interval>& variance = error->variance_interval;
            by_metric[std::string(info.name)] = {{"squared_bias", error->squared_bias},
                                                 {"low", error->squared_bias_interval.least},
                                                 {"high", error->squared_bias_interval.greatest},
                                                 {"variance", error->variance},
                                                 {"variance_low", variance ? json(variance->least) : json()},
                                                 {"variance_high", variance ? json(variance->greatest) : json()}};
        }
        return by_metric;
    }

    json map_json() const {
        const WelchMap map = welch_map(*references_, images_);
        json blocks = json::array();
        for (const WelchBlock& block : map.blocks)
            blocks.push_back({{"difference", block.difference},
                              {"standard_error", block.standard_error},
                              {"degrees", block.degrees},
                              {"p", block.p},
                              {"found", block.found}});
        return {{"block", map.block},
                {"width", map.size.width},
                {"height", map.size.height},
                {"image_width", size_.width},
                {"image_height", size_.height},
                {"seeds", map.seeds},
                {"level", WelchMap::kLevel},
                {"blocks", std::move(blocks)},
                {"tested", map.tested},
                {"found", map.found},
                {"share_below_level", map.share_below_level},
                {"detectable", map.detectable},
                {"heavy_tailed", map.heavy_tailed},
                {"heavy_blocks", map.heavy_blocks},
                {"text", map.text()}};
    }

    Size2 size_{};
    std::vector<std::vector<float>> images_;
    std::optional<CrossMeter> references_;
    bool missing_ = false;
};

}  // namespace

MeasureSeedsReply measure_seeds(const MeasureSeedsRequest& asked, uint64_t memory_bytes) {
    if (!asked.reference.second) throw Error(ErrorCode::Conflict, "/reference", "the reference is not two films");
    if (asked.films.size() < 2) throw Error(ErrorCode::Conflict, "/films", "bias and noise of one film are one");
    MeasureSeedsReply reply{json::object()};
    for (const std::string& layer : asked.layers)
        if (const LayerOfFilms films(asked, layer, memory_bytes); !films.missing())
            reply.layers[layer] = films.measured();
    return reply;
}

void encode_bias_map(const EncodeBiasMapRequest& asked) {
    try {
        const json& map = asked.map;
        const Size2 size{map.at("image_width").get<uint32_t>(), map.at("image_height").get<uint32_t>()};
        std::vector<BlockMark> marks;
        for (const json& block : map.at("blocks"))
            marks.push_back({block.at("difference").get<double>(), block.at("found").get<bool>()});
        write_png(size, welch_picture(size, map.at("block").get<uint32_t>(), marks), asked.out);
    } catch (const json::exception& error) {
        throw Error(ErrorCode::WrongType, "/map", std::string("is no map of blocks: ") + error.what());
    }
}

}  // namespace photond
