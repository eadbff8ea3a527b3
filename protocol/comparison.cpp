// Every job is read by parse_job_request() from a body put together of the comparison's members; what it finds wrong is
// carried back to where that member came from.

#include "protocol/comparison.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "protocol/comparison_remarks.h"
#include "protocol/object_reader.h"
#include "protocol/param_json.h"
#include "protocol/strict_json.h"

namespace photond {
namespace {

using nlohmann::json;

constexpr size_t kMaxLabelBytes = 256;
constexpr size_t kMaxMetrics = 16;

/// Members that a job has under the same name.
constexpr std::array kShared{"scene",  "camera",      "image", "reference", "stop", "layers",  "priority",
                             "labels", "environment", "glass", "animation", "time", "shutter", "quiet_machine"};

std::string item(const std::string& pointer, size_t index) { return pointer + "/" + std::to_string(index); }

/// Faults of many jobs that share most of their bodies: each is noted once.
class SharedFaults {
public:
    explicit SharedFaults(BodyFaults& faults) : faults_(faults) {}
    void add(ErrorCode code, const std::string& pointer, const std::string& detail) {
        if (noted_.insert({pointer, detail}).second) faults_.add(code, pointer, detail);
    }

private:
    BodyFaults& faults_;
    std::set<std::pair<std::string, std::string>> noted_;
};

/// A parameter and its values, as given.
struct SweptParameter {
    std::string name;
    std::vector<json> values;
};

struct Entry {
    std::string label;
    json method;                        // as given
    std::vector<SweptParameter> sweep;  // by name: a JSON object has no order of its own
    bool good = false;

    size_t rows() const {
        size_t product = 1;
        for (const SweptParameter& parameter : sweep)
            product = std::min(product * parameter.values.size(), kMaxComparisonJobs + 1);
        return product;
    }
};

/// What tells a job's place in the comparison's body.
struct Place {
    size_t entry;
    std::vector<std::pair<std::string, size_t>> values;  // swept parameter, index of its value
    size_t seed;
};

/// Pointer into a job's body -> pointer into the comparison's. Empty: a fault of the probe, not of the body.
std::string mapped(const std::string& pointer, const Place& place, const std::vector<size_t>& metric_places) {
    if (pointer.starts_with("/method")) {
        const std::string entry = item("/entries", place.entry);
        for (const auto& [name, index] : place.values)
            if (pointer == "/method/parameters/" + pointer_token(name))
                return item(entry + "/sweep/" + pointer_token(name), index);
        return entry + pointer;
    }
    if (pointer == "/seed") return item("/seeds", place.seed);
    if (pointer.starts_with("/metrics/")) {
        const size_t index = std::stoul(pointer.substr(9));
        return index < metric_places.size() ? item("/metrics", metric_places[index]) : "/metrics";
    }
    return pointer;
}

/// A non-empty array without null in it; nullptr where it is absent or wrong, which is noted.
const json* read_array(ObjectReader& reader, const std::string& key, bool required, const char* of_what) {
    const json* source = reader.member(key, required);
    if (source == nullptr) return nullptr;
    if (!source->is_array()) {
        reader.faults().add(ErrorCode::WrongType, reader.at(key), "must be an array, got " + value_text(*source));
        return nullptr;
    }
    if (source->empty())
        reader.faults().add(ErrorCode::OutOfRange, reader.at(key), std::string("must name at least one ") + of_what);
    for (size_t i = 0; i < source->size(); ++i)
        if ((*source)[i].is_null())
            reader.faults().add(ErrorCode::WrongType, item(reader.at(key), i), "must not be null");
    return source->empty() ? nullptr : source;
}

/// Notes values that are there twice.
void check_distinct(const json& values, const std::string& pointer, BodyFaults& faults) {
    std::set<json> seen;
    for (size_t i = 0; i < values.size(); ++i)
        if (!seen.insert(values[i]).second)
            faults.add(ErrorCode::Conflict, item(pointer, i), value_text(values[i]) + " is given twice");
}

std::vector<SweptParameter> read_sweep(const json& source, const std::string& pointer, const json* method,
                                       BodyFaults& faults) {
    std::vector<SweptParameter> sweep;
    if (!source.is_object()) {
        faults.add(ErrorCode::WrongType, pointer,
                   "must be an object of parameters and their values, got " + value_text(source));
        return sweep;
    }
    const json none = json::object();
    const json* fixed = &none;
    if (method != nullptr && method->is_object())
        if (const auto found = method->find("parameters"); found != method->end() && found->is_object())
            fixed = &*found;
    ObjectReader reader(source, pointer, faults);
    for (const auto& [name, given] : source.items()) {
        const json* values = read_array(reader, name, true, "value");
        if (const auto found = fixed->find(name); found != fixed->end() && !found->is_null())
            faults.add(ErrorCode::Conflict, reader.at(name),
                       value_text(name) + " has a value in method.parameters already");
        if (values == nullptr) continue;
        check_distinct(*values, reader.at(name), faults);
        sweep.push_back({name, *values});
    }
    return sweep;
}

/// Sweeps are written into method.parameters; where that is no object the job's reader says so, without them.
void make_room_for_sweep(Entry& entry) {
    if (entry.sweep.empty()) return;
    if (entry.method.is_object()) {
        json& parameters = entry.method["parameters"];
        if (parameters.is_null()) parameters = json::object();
        if (parameters.is_object()) return;
    }
    entry.sweep.clear();
}

/// Notes swept parameters that the method does not have; once for each, not once for each value.
bool check_swept_names(const Entry& entry, const std::string& pointer, const JobVocabulary& vocabulary,
                       BodyFaults& faults) {
    const json name = entry.method.is_object() ? entry.method.value("name", json()) : json();
    const auto& methods = vocabulary.method_names;
    if (!name.is_string() || std::find(methods.begin(), methods.end(), name.get<std::string>()) == methods.end())
        return true;  // the job's reader says so
    const json known = params_to_json(*vocabulary.make_params(name.get<std::string>()));
    std::vector<std::string> names;
    for (const auto& [parameter, value] : known.items()) names.push_back(parameter);
    const size_t faults_before = faults.size();
    for (const SweptParameter& parameter : entry.sweep)
        if (!known.contains(parameter.name))
            faults.add(ErrorCode::UnknownField, pointer + "/sweep/" + pointer_token(parameter.name),
                       "unknown parameter" + did_you_mean(parameter.name, names));
    return faults.size() == faults_before;
}

Entry read_entry(const json& source, const std::string& pointer, BodyFaults& faults) {
    Entry entry;
    const size_t faults_before = faults.size();
    ObjectReader reader(source, pointer, faults);
    if (!source.is_object()) return entry;
    const auto label = reader.string("label", kMaxLabelBytes);
    const json* method = reader.member("method", true);
    const json* sweep = reader.member("sweep");
    reader.finish();
    if (sweep) entry.sweep = read_sweep(*sweep, reader.at("sweep"), method, faults);
    if (method) entry.method = *method;
    if (label)
        entry.label = *label;
    else if (method && method->is_object() && method->contains("name") && (*method)["name"].is_string())
        entry.label = (*method)["name"].get<std::string>();
    make_room_for_sweep(entry);
    entry.good = faults.size() == faults_before;
    return entry;
}

std::vector<Entry> read_entries(ObjectReader& body, const JobVocabulary& vocabulary) {
    std::vector<Entry> entries;
    const json* source = read_array(body, "entries", true, "entry");
    if (source == nullptr) return entries;
    for (size_t i = 0; i < source->size(); ++i) {
        const std::string pointer = item(body.at("entries"), i);
        Entry entry = read_entry((*source)[i], pointer, body.faults());
        entry.good = check_swept_names(entry, pointer, vocabulary, body.faults()) && entry.good;
        const auto same = [&](const Entry& other) { return !entry.label.empty() && other.label == entry.label; };
        if (const auto found = std::find_if(entries.begin(), entries.end(), same); found != entries.end())
            body.faults().add(ErrorCode::Conflict, pointer + "/label",
                              "entry " + std::to_string(found - entries.begin()) + " has the label " +
                                  value_text(entry.label) + " too; labels must differ");
        entries.push_back(std::move(entry));
    }
    return entries;
}

std::vector<std::string> read_metrics(ObjectReader& body, const JobVocabulary& vocabulary, SharedFaults& faults) {
    const json* source = read_array(body, "metrics", false, "metric");
    if (source == nullptr) return {"relative_mse"};
    if (source->size() > kMaxMetrics)
        faults.add(ErrorCode::OutOfRange, body.at("metrics"),
                   std::to_string(source->size()) + " metrics, at most " + std::to_string(kMaxMetrics) + " are shown");
    std::vector<std::string> metrics;
    for (size_t i = 0; i < source->size(); ++i) {
        const json& metric = (*source)[i];
        const std::string pointer = item(body.at("metrics"), i);
        if (metric.is_null()) continue;
        if (!metric.is_string()) {
            faults.add(ErrorCode::WrongType, pointer, "must be a string, got " + value_text(metric));
            continue;
        }
        const auto name = metric.get<std::string>();
        BodyFaults wrong;
        check_metric_name(name, pointer, vocabulary, wrong);
        try {
            wrong.throw_if_any();
        } catch (const Error& error) {
            for (const Fault& fault : error.faults) faults.add(fault.code, fault.pointer, fault.detail);
            continue;
        }
        if (std::find(metrics.begin(), metrics.end(), name) != metrics.end())
            faults.add(ErrorCode::Conflict, pointer, value_text(metric) + " is named twice");
        else
            metrics.push_back(name);
    }
    return metrics;
}

bool is_estimated(const std::string& metric, const JobVocabulary& vocabulary) {
    const auto& estimated = vocabulary.estimated_metrics;
    return std::find(estimated.begin(), estimated.end(), metric) != estimated.end();
}

/// Makes the jobs' bodies and reads them.
class Planner {
public:
    Planner(const json& body, const std::vector<std::string>& metrics, const JobVocabulary& vocabulary,
            SharedFaults& faults)
        : vocabulary_(vocabulary), faults_(faults) {
        for (const char* key : kShared)
            if (const auto found = body.find(key); found != body.end()) shared_[key] = *found;
        json wanted = json::array();
        for (size_t i = 0; i < metrics.size(); ++i)
            if (!is_estimated(metrics[i], vocabulary)) {
                wanted.push_back(metrics[i]);
                metric_places_.push_back(i);
            }
        // Efficiency is of the layer that the first metric measures, and takes that layer's rmse.
        if (!metrics.empty() && layer_of_metric(metrics[0]) != "beauty") {
            const std::string rmse = layer_of_metric(metrics[0]) + ":rmse";
            if (std::find(wanted.begin(), wanted.end(), json(rmse)) == wanted.end()) {
                wanted.push_back(rmse);
                metric_places_.push_back(0);
            }
        }
        shared_["metrics"] = std::move(wanted);
    }

    /// The faults of what all jobs share, where there is no job that would show them.
    void probe_shared() {
        try {
            parse_job_request(shared_, vocabulary_);
        } catch (const Error& error) {
            for (const Fault& fault : error.faults)
                if (!fault.pointer.starts_with("/method"))
                    faults_.add(fault.code, mapped(fault.pointer, {}, metric_places_), fault.detail);
        }
    }

    void plan_entry(size_t index, const Entry& entry, const json& seeds, std::vector<PlannedJob>& jobs) {
        json body = shared_;
        body["method"] = entry.method;
        std::set<json> rows;
        std::vector<size_t> digits(entry.sweep.size(), 0);  // of the row's number; the last parameter varies fastest
        for (size_t row = 0; row < entry.rows(); ++row) {
            Place place{index, {}, 0};
            for (size_t p = 0; p < entry.sweep.size(); ++p) {
                body["method"]["parameters"][entry.sweep[p].name] = entry.sweep[p].values[digits[p]];
                place.values.emplace_back(entry.sweep[p].name, digits[p]);
            }
            const size_t first = jobs.size();
            for (size_t s = 0; s < seeds.size(); ++s) {
                body["seed"] = seeds[s];
                place.seed = s;
                plan_job(body, entry, place, jobs);
            }
            // Values that differ on the wire may be the same float.
            if (first < jobs.size() && !rows.insert(jobs[first].parameters).second)
                faults_.add(ErrorCode::Conflict, item("/entries", index) + "/sweep",
                            "two values are the same once read: " + value_text(jobs[first].parameters));
            for (size_t p = digits.size(); p-- > 0 && ++digits[p] == entry.sweep[p].values.size();) digits[p] = 0;
        }
    }

private:
    void plan_job(const json& body, const Entry& entry, const Place& place, std::vector<PlannedJob>& jobs) {
        try {
            PlannedJob job;
            job.entry = place.entry;
            job.label = entry.label;
            job.request = parse_job_request(body, vocabulary_);
            job.seed = job.request.seed;
            job.parameters = json::object();
            for (const SweptParameter& parameter : entry.sweep)
                job.parameters[parameter.name] = job.request.method.parameters.at(parameter.name);
            jobs.push_back(std::move(job));
        } catch (const Error& error) {
            for (const Fault& fault : error.faults)
                faults_.add(fault.code, mapped(fault.pointer, place, metric_places_), fault.detail);
        }
    }

    const JobVocabulary& vocabulary_;
    SharedFaults& faults_;
    json shared_ = json::object();
    std::vector<size_t> metric_places_;  // of each metric of a job, its index in the comparison's
};

/// The entry as understood. Swept parameters stand in the sweep alone, so that the echo reads as the body did.
json echo_of(const Entry& entry, const PlannedJob& first) {
    json method = to_json(first.request.method);
    json sweep = json::object();
    for (const SweptParameter& parameter : entry.sweep) {
        method["parameters"].erase(parameter.name);
        sweep[parameter.name] = parameter.values;
    }
    return {{"label", entry.label}, {"method", std::move(method)}, {"sweep", std::move(sweep)}};
}

json echo_of(const ComparisonRequest& request, const std::vector<Entry>& entries) {
    const json first = to_json(request.jobs.front().request);
    json echo = json::object();
    for (const char* key : kShared) echo[key] = first.at(key);
    echo["metrics"] = request.metrics;
    json list = json::array(), seeds = json::array();
    for (size_t i = 0; i < entries.size(); ++i) {
        const auto job = std::find_if(request.jobs.begin(), request.jobs.end(),
                                      [&](const PlannedJob& planned) { return planned.entry == i; });
        list.push_back(echo_of(entries[i], *job));
    }
    for (const PlannedJob& job : request.jobs) {
        if (!seeds.empty() && job.seed == seeds.front().get<uint64_t>()) break;  // the next row
        seeds.push_back(job.seed);
    }
    echo["entries"] = std::move(list);
    echo["seeds"] = std::move(seeds);
    return echo;
}

size_t count_jobs(const std::vector<Entry>& entries, size_t seeds) {
    size_t rows = 0;
    for (const Entry& entry : entries) rows = std::min(rows + entry.rows(), kMaxComparisonJobs + 1);
    return rows * seeds;
}

}  // namespace

ComparisonRequest parse_comparison_request(const json& body, const JobVocabulary& vocabulary) {
    BodyFaults faults;
    ObjectReader reader(body, "", faults);
    if (!body.is_object()) faults.throw_if_any();  // else every required field would be called missing too
    SharedFaults shared_faults(faults);

    for (const char* key : kShared) reader.member(key);
    const std::vector<Entry> entries = read_entries(reader, vocabulary);
    ComparisonRequest request;
    request.metrics = read_metrics(reader, vocabulary, shared_faults);
    const json* given_seeds = read_array(reader, "seeds", false, "seed");
    const json seeds = given_seeds ? *given_seeds : json::array({1u});
    if (given_seeds) check_distinct(seeds, "/seeds", faults);
    const json remarks = read_remarks(body, reader, faults);
    reader.finish();

    const bool needs_reference = std::any_of(request.metrics.begin(), request.metrics.end(),
                                             [&](const auto& metric) { return !is_estimated(metric, vocabulary); });
    const bool has_reference = body.contains("reference") && !body["reference"].is_null();
    if (needs_reference && !has_reference)
        faults.add(ErrorCode::MissingField, "/reference",
                   "is required: " + value_text(request.metrics.front()) + " is measured against one");
    const size_t count = count_jobs(entries, seeds.size());
    if (count > kMaxComparisonJobs)
        faults.add(ErrorCode::OutOfRange, "/entries",
                   "entries, sweeps and seeds make " +
                       (count / seeds.size() > kMaxComparisonJobs ? "too many" : std::to_string(count)) +
                       " jobs, a comparison has at most " + std::to_string(kMaxComparisonJobs));
    // A reference that is missing has been noted above; that metrics need one would say it again.
    Planner planner(body, needs_reference && !has_reference ? std::vector<std::string>() : request.metrics, vocabulary,
                    shared_faults);
    const bool any_good = std::any_of(entries.begin(), entries.end(), [](const Entry& entry) { return entry.good; });
    if (!any_good || count > kMaxComparisonJobs) {
        planner.probe_shared();
        faults.throw_if_any();
    }
    for (size_t i = 0; i < entries.size(); ++i)
        if (entries[i].good) planner.plan_entry(i, entries[i], seeds, request.jobs);
    faults.throw_if_any();
    request.echo = echo_of(request, entries);
    request.echo.update({{"title", nullptr}, {"notes", nullptr}});
    request.echo.update(remarks);
    return request;
}

}  // namespace photond
