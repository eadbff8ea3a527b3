#include "server/service/row_biases.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "protocol/helper_messages.h"
#include "renderer/error/metric.h"
#include "renderer/film/layers.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint32_t kLookedAtFirst = 100;  // comparisons, the newest; older ones when somebody looks at them
constexpr std::chrono::seconds kPause{1};
// A layer whose measuring has failed is measured again after the first, and each time after so many times that.
constexpr std::chrono::seconds kFirstPause{2}, kLongestPause{600};
constexpr int kLongerEachTime = 4;
constexpr int kMostFaults = 4;  // of a layer that the helper crashes or times out on

enum class Outlook : uint8_t {
    Lasting,  // as long as the films are these
    Doubtful,
    Passing,  // nothing that the films are to blame for
};

Outlook outlook(ErrorCode code) {
    switch (code) {
        case ErrorCode::NotFound:
        case ErrorCode::Conflict:
        case ErrorCode::ResultLost:
        case ErrorCode::ResultDamaged:
        case ErrorCode::OutOfMemory: return Outlook::Lasting;
        case ErrorCode::NoSpace:
        case ErrorCode::WorkerLost: return Outlook::Passing;
        default: return Outlook::Doubtful;
    }
}

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
    try {
        for (const ComparisonRow& row : core_.store.comparisons(INT64_MAX, kLookedAtFirst))
            core_.comparisons_to_look_at.insert(row.seq);
    } catch (const std::exception& error) {
        spdlog::warn("bias and noise of earlier comparisons' rows are measured when somebody looks at them: {}",
                     error.what());
    }
    while (const std::optional<int64_t> comparison = next(lock)) {
        settled_.erase(*comparison);
        looks_at_ = *comparison;
        lock.unlock();
        std::optional<SteadyClock::time_point> again;
        try {
            again = measure_rows(*comparison);
        } catch (const std::exception& error) {
            spdlog::warn("comparison {}: its bias is not measured: {}", comparison_id(*comparison), error.what());
            again = SteadyClock::now() + kLongestPause;
        }
        lock.lock();
        looks_at_ = 0;
        if (again) later_[*comparison] = *again;
        settled_.insert(*comparison);
        core_.attempt_changed.notify_all();
        // To look at a comparison takes time that its jobs would miss.
        if (core_.jobs_on_host_cores > 0) pause(lock);
    }
}

std::optional<int64_t> RowBiases::next(std::unique_lock<std::mutex>& lock) {
    std::set<int64_t>& wanted = core_.comparisons_to_look_at;
    while (!core_.stopping) {
        const auto now = SteadyClock::now();
        auto soonest = SteadyClock::time_point::max();
        std::erase_if(later_, [&](const auto& later) {
            if (later.second > now)
                soonest = std::min(soonest, later.second);
            else
                wanted.insert(later.first);
            return later.second <= now;
        });
        if (!wanted.empty()) return wanted.extract(std::prev(wanted.end())).value();
        if (later_.empty())
            core_.attempt_changed.wait(lock);
        else
            core_.attempt_changed.wait_until(lock, soonest);
    }
    return std::nullopt;
}

void RowBiases::pause(std::unique_lock<std::mutex>& lock) {
    core_.attempt_changed.wait_for(lock, kPause, [&] { return core_.stopping; });
}

std::vector<RowBiases::Unmeasured> RowBiases::unmeasured(int64_t comparison) {
    const Compared compared = read_(comparison_id(comparison));
    const Judged judged = judge(compared);
    const std::vector<std::string> layers = layers_of_bias(compared);
    std::vector<Unmeasured> unmeasured;
    for (const TableRow& row : judged.table.rows) {
        const RowFilms films = films_of_row(compared, row);
        if (!films.measurable()) continue;
        for (const std::string& layer : layers)
            if (std::none_of(compared.biases.begin(), compared.biases.end(),
                             [&](const RowBias& bias) { return bias.films == films.name && bias.layer == layer; }))
                unmeasured.push_back({films, layer});
    }
    const std::lock_guard lock(core_.mutex);
    std::erase_if(unmeasured, [&](const Unmeasured& of) { return lost_.contains(of.name()); });
    return unmeasured;
}

bool RowBiases::is_due(const Unmeasured& unmeasured, SteadyClock::time_point now) const {
    const auto failed = failed_.find(unmeasured.name());
    return failed == failed_.end() || failed->second.again <= now;
}

std::optional<SteadyClock::time_point> RowBiases::measure_rows(int64_t comparison) {
    std::vector<Unmeasured> left;
    try {
        left = unmeasured(comparison);
    } catch (const Error& error) {
        if (error.code == ErrorCode::NotFound) return std::nullopt;  // it has been removed
        throw;
    }
    std::optional<SteadyClock::time_point> again;
    for (const Unmeasured& of : left) {
        std::unique_lock lock(core_.mutex);
        while (!core_.stopping && is_due(of, SteadyClock::now())) {
            lock.unlock();
            const bool measured = measured_now(comparison, of);
            lock.lock();
            if (measured) break;
            pause(lock);
        }
        if (core_.stopping) break;
        if (const auto failed = failed_.find(of.name()); failed != failed_.end())
            again = std::min(again.value_or(SteadyClock::time_point::max()), failed->second.again);
    }
    return again;
}

bool RowBiases::measured_now(int64_t comparison, const Unmeasured& unmeasured) {
    std::string why;
    ErrorCode code = ErrorCode::Internal;
    try {
        measure(comparison, unmeasured);
        const std::lock_guard lock(core_.mutex);
        failed_.erase(unmeasured.name());
        return true;
    } catch (const Error& error) {
        // A job renders, or the helper is started again.
        if (error.code == ErrorCode::Unavailable) return false;
        code = error.code, why = error.what();
    } catch (const std::exception& error) {
        why = error.what();
    }
    const bool ever_again = failed(unmeasured, code);
    spdlog::warn("comparison {}: bias and noise of a row's {} are not measured{}: {}", comparison_id(comparison),
                 unmeasured.layer, ever_again ? " now" : "", why);
    return true;
}

bool RowBiases::failed(const Unmeasured& unmeasured, ErrorCode code) {
    const std::lock_guard lock(core_.mutex);
    Failed& failed = failed_[unmeasured.name()];
    const Outlook outlook_now = outlook(code);
    if (outlook_now == Outlook::Doubtful) ++failed.faults;
    if (outlook_now == Outlook::Lasting || failed.faults >= kMostFaults) {
        lost_.insert(unmeasured.name());
        failed_.erase(unmeasured.name());
        return false;
    }
    failed.pause = std::clamp<std::chrono::seconds>(kLongerEachTime * failed.pause, kFirstPause, kLongestPause);
    failed.again = SteadyClock::now() + failed.pause;
    return true;
}

void RowBiases::measure(int64_t comparison, const Unmeasured& unmeasured) {
    const auto& [films, layer] = unmeasured;
    std::vector<FilmSource> pinned;
    const auto pin = [&](int64_t seq) {
        FilmSource film = films_.film_source(job_id(seq));
        films_.pin(film);
        return pinned.emplace_back(std::move(film)).path;
    };
    MeasureSeedsRequest request;
    request.layers = {layer};
    for (const int64_t seq : films.jobs) request.films.push_back(pin(seq));
    request.reference.first.film = pin(films.references.at(0));
    request.reference.second.emplace().film = pin(films.references.at(1));
    const std::string key = cache_key(comparison, films.name, "errors/" + layer);
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
    const auto of_layer = by_layer.find(layer);
    if (of_layer == by_layer.end()) {  // a film has no such layer
        lost_.insert(unmeasured.name());
        return;
    }
    auto transaction = core_.store.transaction();
    core_.store.put_row_bias(comparison, {films.name, layer, of_layer->at("errors").dump()},
                             of_layer->at("map").dump());
    transaction.commit();
}

void RowBiases::settle(const std::string& id) {
    const int64_t comparison = group_seq(GroupKind::Comparison, id);
    std::unique_lock lock(core_.mutex);
    std::set<int64_t>& wanted = core_.comparisons_to_look_at;
    const auto settled = [&] { return settled_.contains(comparison) && !wanted.contains(comparison); };
    if (comparison == 0 || settled() || core_.jobs_on_host_cores > 0) return;
    const std::vector<JobProgress> jobs = core_.store.comparison_progress(comparison);
    if (jobs.empty() || std::any_of(jobs.begin(), jobs.end(), [](const auto& job) { return !is_over(job.state); }))
        return;
    wanted.insert(comparison);
    core_.attempt_changed.notify_all();
    const bool others_first =
        (looks_at_ != 0 && looks_at_ != comparison) || wanted.upper_bound(comparison) != wanted.end();
    if (others_first || callers_ >= Pictures::kMostCallers) return;
    ++callers_;
    lock.unlock();
    const bool anything = anything_due(comparison);
    lock.lock();
    if (anything)
        core_.attempt_changed.wait_for(lock, kPatience,
                                       [&] { return core_.stopping || settled() || core_.jobs_on_host_cores > 0; });
    --callers_;
}

bool RowBiases::anything_due(int64_t comparison) {
    try {
        const std::vector<Unmeasured> left = unmeasured(comparison);
        const std::lock_guard lock(core_.mutex);
        const auto now = SteadyClock::now();
        return std::any_of(left.begin(), left.end(), [&](const Unmeasured& of) { return is_due(of, now); });
    } catch (const std::exception&) {  // who asks for the comparison is told
        return false;
    }
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
    const auto kept = [&] {
        const std::lock_guard lock(core_.mutex);
        return core_.store.row_bias_map(measured.comparison, measured.films.name, layer);
    };
    std::optional<std::string> map = kept();
    if (!map && !measured.films.measurable())
        throw Error(ErrorCode::NotFound,
                    "row " + std::to_string(index) + " of comparison " + id + " has no map: " + measured.films.why_not);
    if (!map) {
        measure(measured.comparison, {measured.films, layer});
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
