#include "server/service/row_films.h"

#include <algorithm>

#include "renderer/core/sha256.h"
#include "renderer/error/cross_meter.h"
#include "renderer/error/metric.h"
#include "renderer/methods/registry.h"
#include "server/comparisons/report_text.h"
#include "server/service/references.h"

namespace photond {

using nlohmann::json;

namespace {

std::string parameter_text(const json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

/// Whether more passes lower its bias (MethodInfo::bias_falls_with).
bool bias_falls(const JobRow& job) {
    const MethodInfo* method = find_method(job.method);
    if (!method || !method->bias_falls_with) return false;
    const json request = json::parse(job.request),
               parameters = request.at("method").value("parameters", json::object());
    return std::all_of(method->bias_falls_with->begin(), method->bias_falls_with->end(),
                       [&](const ParamSetting& setting) {
                           const auto parameter = parameters.find(std::string(setting.name));
                           return parameter != parameters.end() && parameter_text(*parameter) == setting.word;
                       });
}

std::string sentence(const BiasApart& bias, const std::string& metric) {
    if (!(bias.low > 0))
        return "no bias is seen" +
               (bias.high > 0 ? ": it adds at most " + short_number(bias.high) + " to the " + metric : "");
    const std::string figure = short_number(bias.squared_bias) + " (between " + short_number(bias.low) + " and " +
                               short_number(bias.high) + ")";
    if (bias.floor) return "more passes reach no " + metric + " below the squared bias, " + figure;
    return "the squared bias at these passes is " + figure + ", and falls with more";
}

BiasApart bias_read(const json& measured, bool floor, const std::string& metric) {
    const auto optional = [&](const char* name) {
        const json& value = measured.at(name);
        return value.is_null() ? std::optional<double>() : std::optional(value.get<double>());
    };
    BiasApart bias;
    bias.squared_bias = measured.at("squared_bias").get<double>();
    bias.low = measured.at("low").get<double>(), bias.high = measured.at("high").get<double>();
    bias.variance = measured.at("variance").get<double>();
    bias.variance_low = optional("variance_low"), bias.variance_high = optional("variance_high");
    bias.floor = floor;
    bias.text = sentence(bias, metric);
    return bias;
}

RowFilms none(std::string why_not) { return {{}, {}, "", std::move(why_not)}; }

}  // namespace

RowFilms films_of_row(const Compared& compared, const TableRow& row) {
    if (row.seeds < 2) return none("it has one seed, whose bias and noise cannot be told apart");
    if (row.succeeded < row.seeds) return none("not all of its jobs have succeeded");
    RowFilms films;
    std::string names;
    for (const std::string& id : row.jobs) {
        const auto job = std::find_if(compared.jobs.begin(), compared.jobs.end(),
                                      [&](const auto& any) { return job_id(any.second.seq) == id; });
        if (job == compared.jobs.end()) return none("a film of its jobs is lost");
        const JobRow& of_seed = job->second;
        if (films.jobs.empty()) films.references = of_seed.reference_jobs;
        if (of_seed.reference_jobs != films.references) return none("its jobs have different references");
        if (of_seed.film.empty()) films.why_not = "a film of its jobs is lost";
        films.jobs.push_back(of_seed.seq);
        names += id + "/" + std::to_string(of_seed.attempt) + "\n";
    }
    if (films.references.size() != References::kFilms) return none("its reference is not two films");
    for (const int64_t seq : films.references) {
        const auto film = std::find_if(compared.references.begin(), compared.references.end(),
                                       [&](const JobRow& any) { return any.seq == seq; });
        if (film == compared.references.end() || film->state != JobState::Succeeded || film->film.empty())
            films.why_not = "a film of its reference is lost";
        names += job_id(seq) + "\n";
    }
    films.name = sha256_hex(names.data(), names.size());
    return films;
}

std::vector<std::string> layers_of_bias(const Compared& compared) {
    std::vector<std::string> layers{LayerMetric().layer};
    const json request = json::parse(compared.row.request);
    for (const json& name : request.at("metrics"))
        if (const auto metric = layer_metric_named(name.get<std::string>());
            metric && is_quadratic(metric->metric) &&
            std::find(layers.begin(), layers.end(), metric->layer) == layers.end())
            layers.push_back(metric->layer);
    return layers;
}

void add_biases(ComparisonTable& table, const Compared& compared) {
    for (TableRow& row : table.rows) {
        const RowFilms films = films_of_row(compared, row);
        std::vector<const RowBias*> kept;
        for (const RowBias& measured : compared.biases)
            if (measured.films == films.name) kept.push_back(&measured);
        if (films.name.empty() || kept.empty()) continue;
        const auto job = std::find_if(compared.jobs.begin(), compared.jobs.end(),
                                      [&](const auto& any) { return any.second.seq == films.jobs.front(); });
        const bool floor = !bias_falls(job->second);
        std::map<std::string, BiasApart>& biases = row.bias.emplace();
        for (const std::string& name : table.metrics) {
            const auto metric = mean_square_named(name);
            if (!metric) continue;
            for (const RowBias* measured : kept) {
                if (measured->layer != metric->layer) continue;
                const json errors = json::parse(measured->errors);
                const auto error = errors.find(std::string(metric_info(metric->metric).name));
                if (error != errors.end()) biases[metric->name()] = bias_read(*error, floor, metric->name());
            }
        }
    }
}

}  // namespace photond
