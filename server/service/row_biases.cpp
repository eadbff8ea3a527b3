#include "server/service/row_biases.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>

#include "protocol/helper_messages.h"
#include "renderer/error/metric.h"
#include "renderer/film/layers.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint32_t kLookedAtFirst = 100;  // comparisons, the newest; older ones when somebody looks at them
constexpr std::chrono::seconds kPause{1};

/// All that is measured is forgotten with the comparison.
std::string cache_key(int64_t comparison, const std::string& films, const std::string& what) {
    return "comparison/" + std::to_string(comparison) + "/bias/" + films + "/" + what;
}

void check_radiance(const std::string& layer) {
    const LayerInfo* info = find_layer(layer);
    if (layer != LayerMetric().layer && !(info && info->radiance()))
        throw Error(ErrorCode::UnknownName, "/layer", "'" + layer + "' is no layer of radiance");
}

}  // namespace

RowBiases::~RowBiases() {
    if (thread_.joinable()) thread_.join();
}

void RowBiases::start() {
    thread_ = std::thread([this] { run(); });
}

void RowBiases::run() {
    std::unique_lock lock(core_.mutex);
    std::set<int64_t>& wanted = core_.comparisons_to_look_at;
    for (const ComparisonRow& row : core_.store.comparisons(INT64_MAX, kLookedAtFirst)) wanted.insert(row.seq);
    while (true) {
        core_.attempt_changed.wait(lock, [&] { return core_.stopping || !wanted.empty(); });
        if (core_.stopping) return;
        const int64_t comparison = *wanted.rbegin();
        wanted.erase(comparison);
        settled_.erase(comparison);
        lock.unlock();
        try {
            measure_rows(comparison);
        } catch (const std::exception& error) {
            spdlog::warn("comparison {}: its bias is not measured: {}", comparison_id(comparison), error.what());
        }
        lock.lock();
        if (!wanted.contains(comparison)) settled_.insert(comparison);
        core_.attempt_changed.notify_all();
        // To look at a comparison takes time that its jobs would miss.
        if (core_.jobs_on_host_cores > 0) pause(lock);
    }
}

void RowBiases::pause(std::unique_lock<std::mutex>& lock) {
    core_.attempt_changed.wait_for(lock, kPause, [&] { return core_.stopping; });
}

void RowBiases::measure_rows(int64_t comparison) {
    Compared compared;
    try {
        compared = read_(comparison_id(comparison));
    } catch (const Error&) {  // it has been removed
        return;
    }
    const Judged judged = judge(compared);
    const std::vector<std::string> layers = layers_of_bias(compared);
    for (const TableRow& row : judged.table.rows) {
        const RowFilms films = films_of_row(compared, row);
        const bool known = std::any_of(compared.biases.begin(), compared.biases.end(),
                                       [&](const RowBias& bias) { return bias.films == films.name; });
        if (!films.measurable() || known || lost_.contains(films.name)) continue;
        while (!measured_now(comparison, films, layers)) {
            std::unique_lock lock(core_.mutex);
            pause(lock);
            if (core_.stopping) return;
        }
    }
}

bool RowBiases::measured_now(int64_t comparison, const RowFilms& films, const std::vector<std::string>& layers) {
    try {
        measure(comparison, films, layers);
    } catch (const Error& error) {
        // A job renders, or the helper is started again.
        if (error.code == ErrorCode::Unavailable) return false;
        lost_.insert(films.name);
        spdlog::warn("comparison {}: bias and noise of a row are not measured: {}", comparison_id(comparison),
                     error.what());
    }
    return true;
}

void RowBiases::measure(int64_t comparison, const RowFilms& films, const std::vector<std::string>& layers) {
    std::vector<FilmSource> pinned;
    const auto pin = [&](int64_t seq) {
        FilmSource film = films_.film_source(job_id(seq));
        films_.pin(film);
        return pinned.emplace_back(std::move(film)).path;
    };
    MeasureSeedsRequest request;
    request.layers = layers;
    for (const int64_t seq : films.jobs) request.films.push_back(pin(seq));
    request.reference.first.film = pin(films.references.at(0));
    request.reference.second.emplace().film = pin(films.references.at(1));
    std::string what = "errors";
    for (const std::string& layer : layers) what += "/" + layer;
    const std::string key = cache_key(comparison, films.name, what);
    const Artefact measured = pictures_.drawn_beside(
        key, key, "application/json", [request, pinned](const Draughtsman& by, const fs::path& path) {
            std::ofstream out(path, std::ios::binary);
            out << by.helper.ask(request).layers;
            out.close();
            if (!out) throw Error(ErrorCode::NoSpace, "cannot write " + path.string());
            return std::map<std::string, std::string>();
        });
    std::ifstream in(measured.path, std::ios::binary);
    const json by_layer = json::parse(in);
    const std::lock_guard lock(core_.mutex);
    if (!core_.store.comparison(comparison)) return;
    auto transaction = core_.store.transaction();
    for (const auto& [layer, of_layer] : by_layer.items())
        core_.store.put_row_bias(comparison, {films.name, layer, of_layer.at("errors").dump()},
                                 of_layer.at("map").dump());
    transaction.commit();
}

void RowBiases::settle(const std::string& id) {
    const int64_t comparison = comparison_seq(id);
    std::unique_lock lock(core_.mutex);
    const auto settled = [&] {
        return settled_.contains(comparison) && !core_.comparisons_to_look_at.contains(comparison);
    };
    if (comparison == 0 || settled() || core_.jobs_on_host_cores > 0) return;
    const std::vector<JobProgress> jobs = core_.store.comparison_progress(comparison);
    if (jobs.empty() || std::any_of(jobs.begin(), jobs.end(), [](const auto& job) { return !is_over(job.state); }))
        return;
    core_.comparisons_to_look_at.insert(comparison);
    core_.attempt_changed.notify_all();
    core_.attempt_changed.wait_for(lock, kPatience,
                                   [&] { return core_.stopping || settled() || core_.jobs_on_host_cores > 0; });
}

RowBiases::MeasuredRow RowBiases::measured_row(const std::string& id, size_t index, const std::string& layer) {
    check_radiance(layer);
    const Compared compared = read_(id);
    const Judged judged = judge(compared);
    if (index >= judged.table.rows.size())
        throw Error(ErrorCode::NotFound, "the table of comparison " + id + " has " +
                                             std::to_string(judged.table.rows.size()) + " rows, and none at " +
                                             std::to_string(index));
    const TableRow& row = judged.table.rows[index];
    MeasuredRow measured{compared.row.seq, row_name(row.label, row.parameters), films_of_row(compared, row), {}};
    if (!measured.films.measurable())
        throw Error(ErrorCode::NotFound,
                    "row " + std::to_string(index) + " of comparison " + id + " has no map: " + measured.films.why_not);
    const auto kept = [&] {
        const std::lock_guard lock(core_.mutex);
        return core_.store.row_bias_map(measured.comparison, measured.films.name, layer);
    };
    std::optional<std::string> map = kept();
    if (!map) {
        measure(measured.comparison, measured.films, {layer});
        map = kept();
    }
    if (!map) throw Error(ErrorCode::NotFound, "not all films of that row have a layer '" + layer + "'");
    measured.map = json::parse(*map);
    return measured;
}

Artefact RowBiases::map_json(const std::string& id, size_t index, const std::string& layer) {
    MeasuredRow measured = measured_row(id, index, layer);
    json& map = measured.map;
    map["row"] = index, map["label"] = measured.label, map["layer"] = layer;
    const std::string text = map.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
    return artefact_files_.text_artefact(cache_key(measured.comparison, measured.films.name, "json/"), text,
                                         "application/json");
}

Artefact RowBiases::map_picture(const std::string& id, size_t index, const std::string& layer) {
    const MeasuredRow measured = measured_row(id, index, layer);
    const std::string key = cache_key(measured.comparison, measured.films.name, "png/" + layer);
    return pictures_.picture(key, key, "image/png", [map = measured.map](const Draughtsman& by, const fs::path& path) {
        by.helper.ask(EncodeBiasMapRequest{map, path});
        return std::map<std::string, std::string>();
    });
}

}  // namespace photond
