// What jobs are measured against: other jobs, uploaded images, and renderings made for it once and kept by content. A
// job waits beside the queue until its reference is over.

#include <spdlog/spdlog.h>

#include <algorithm>

#include "protocol/problem.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/service_impl.h"

namespace photond {

using nlohmann::json;

namespace {

/// Metrics a request names, with their places.
std::vector<std::pair<std::string, std::string>> measured(const JobRequest& request) {
    std::vector<std::pair<std::string, std::string>> metrics;
    if (request.stop.target) metrics.emplace_back(request.stop.target->metric, "/stop/target/metric");
    for (size_t i = 0; i < request.metrics.size(); ++i)
        metrics.emplace_back(request.metrics[i], "/metrics/" + std::to_string(i));
    return metrics;
}

bool is_kept_always(const std::string& layer) {
    if (layer == "beauty") return true;
    for (const LayerInfo& info : kLayers)
        if (info.name == layer) return LayerSet().has(info.layer);
    return false;
}

/// Refuses metrics of layers that the reference does not hold.
void check_layers(const JobRequest& request, const std::string& reference, const std::vector<std::string>& layers) {
    std::vector<Fault> faults;
    for (const auto& [metric, pointer] : measured(request)) {
        const std::string layer = layer_of_metric(metric);
        if (is_kept_always(layer) || std::find(layers.begin(), layers.end(), layer) != layers.end()) continue;
        faults.push_back({pointer, std::string("'")
                                       .append(metric)
                                       .append("' needs the layer '")
                                       .append(layer)
                                       .append("', which ")
                                       .append(reference)
                                       .append(" has not")});
    }
    if (faults.empty()) return;
    const std::string first = faults.front().detail;
    throw Error(ErrorCode::Conflict, first, std::move(faults));
}

void check_same_size(const JobRequest& request, const std::string& reference, int64_t width, int64_t height) {
    if (width == request.width && height == request.height) return;
    throw Error(ErrorCode::Conflict, "/reference",
                reference + " has " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels, the image is to have " + std::to_string(request.width) + " x " +
                    std::to_string(request.height));
}

std::string named(int64_t seq) { return "its reference, job " + job_id(seq) + ","; }

}  // namespace

std::string Service::Impl::reference_content(const JobRequest& reference, const std::string& scene_id) {
    json canonical = to_json(reference);
    canonical.erase("priority"), canonical.erase("labels");
    canonical["scene"] = scene_id;
    const std::string text = canonical.dump(-1, ' ', false, json::error_handler_t::replace);
    return sha256_hex(text.data(), text.size());
}

JobRequest Service::Impl::reference_request(const JobRequest& request) {
    JobRequest reference = request;
    reference.method = request.reference->rendering->method;
    reference.stop = request.reference->rendering->stop;
    reference.reference.reset();
    reference.metrics.clear();
    reference.labels.clear();
    reference.seed = 1;
    reference.first_pass = 0;
    // Of the layers, the light: that is all there is to measure.
    const MethodInfo* method = find_method(reference.method.name);
    const std::vector<std::string> fills = method ? method->layers_on_request() : std::vector<std::string>();
    reference.layers.clear();
    for (const LayerInfo& info : kLayers)
        if (info.radiance() &&
            std::find(request.layers.begin(), request.layers.end(), info.name) != request.layers.end() &&
            std::find(fills.begin(), fills.end(), info.name) != fills.end())
            reference.layers.emplace_back(info.name);
    return reference;
}

void Service::Impl::check_reference(const JobRequest& request, const SceneRef& scene) {
    if (!request.reference) return;
    if (request.reference->rendering) {
        const JobRequest reference = reference_request(request);
        device_of(reference.method, "/reference/method/device");
        check_parameters(reference.method, "/reference");
        check_size(reference, scene, "/reference/method");
        check_device_memory(reference, scene, "/reference/method");
        return check_layers(request, "'" + reference.method.name + "'", reference.layers);
    }
    if (!request.reference->image.empty()) {
        const auto image = store.image(request.reference->image);
        if (!image)
            throw Error(ErrorCode::UnknownName, "/reference", "there is no image '" + request.reference->image + "'");
        check_same_size(request, "the image", image->width, image->height);
        // Of one with more channels only its reader knows which layers they are.
        if (image->channels <= 4) check_layers(request, "the image", {});
        return;
    }
    const std::string name = "job " + request.reference->job;
    const int64_t seq = job_seq(request.reference->job);
    const auto job = seq ? store.job(seq) : std::nullopt;
    if (!job) throw Error(ErrorCode::UnknownName, "/reference", "there is no " + name);
    if (is_over(job->state) && job->film.empty())
        throw Error(ErrorCode::Conflict, "/reference",
                    name + " " + std::string(job_state_name(job->state)) + " without leaving a film");
    const json theirs = json::parse(job->request);
    check_same_size(request, name, theirs["image"].value("width", int64_t{0}),
                    theirs["image"].value("height", int64_t{0}));
    check_layers(request, name, theirs.value("layers", std::vector<std::string>()));
}

std::optional<JobRow> Service::Impl::missing_reference(const JobRequest& request, const SceneRef& scene,
                                                       std::optional<int64_t>& reference_job) {
    if (!request.reference || !request.reference->rendering) return std::nullopt;
    const JobRequest reference = reference_request(request);
    const std::string content = reference_content(reference, scene.id);
    if (const auto found = usable_reference(content)) {
        reference_job = found->seq;
        return std::nullopt;
    }
    JobRow row;
    row.role = JobRole::Reference;
    row.content = content;
    row.priority = reference.priority;
    row.device = device_of(reference.method, "/reference/method/device");
    row.method = reference.method.name;
    row.scene = scene.id;
    row.request = to_json(reference).dump();
    row.created_ms = now_ms();
    return row;
}

std::optional<JobRow> Service::Impl::usable_reference(const std::string& content) {
    auto found = store.reference_of_content(content);
    if (found && found->cancel_requested) return std::nullopt;  // it is about to be over, unfinished
    return found;
}

int64_t Service::Impl::insert_reference(JobRow reference, Insertion& inserted) {
    if (const auto found = usable_reference(reference.content)) return found->seq;
    store.insert_job(reference);
    store.append_log(reference.seq, reference.created_ms, "queued for " + reference.device + ", to be a reference");
    put_event(inserted.outbox, "state", reference.seq, state_data(reference));
    inserted.rows.push_back(reference);
    return reference.seq;
}

void Service::Impl::raise_reference(int64_t seq, int priority, Insertion& inserted) {
    auto row = store.job(seq);
    if (!row || row->role != JobRole::Reference || row->state != JobState::Queued || row->priority >= priority) return;
    row->priority = priority;
    store.update_job(*row);
    store.append_log(seq, now_ms(), "priority raised to " + std::to_string(priority) + ": a job needs it");
    put_event(inserted.outbox, "state", seq, state_data(*row));
    inserted.rows.push_back(*std::move(row));
}

std::optional<int64_t> Service::Impl::waits_for(const JobRow& row) {
    if (!row.reference_job) return std::nullopt;
    const auto reference = store.job(*row.reference_job);
    if (!reference || is_over(reference->state)) return std::nullopt;
    return reference->seq;
}

std::string Service::Impl::waiting_text(const JobRow& row) {
    const auto seq = waits_for(row);
    return seq ? "; waits for its reference, job " + job_id(*seq) : "";
}

void Service::Impl::enqueue(const JobRow& row) {
    if (row.state != JobState::Queued) return;
    if (const auto until = waits_for(row))
        queue.hold(row.seq, row.priority, row.device, *until);
    else
        queue.push(row.seq, row.priority, row.device);
}

json Service::Impl::reference_source(const JobRow& row) {
    const json request = json::parse(row.request);
    const json reference = request.value("reference", json());
    if (reference.is_null()) return nullptr;
    if (reference.is_string() && reference.get_ref<const std::string&>().starts_with("image:")) {
        const auto image = store.image(reference.get<std::string>().substr(6));
        if (!image) throw Error(ErrorCode::WrongState, "its reference, " + reference.get<std::string>() + ", is gone");
        return {{"image", (files.images / image->file).string()}};
    }
    if (!row.reference_job) throw Error(ErrorCode::WrongState, "its reference has been lost");
    const auto source = store.job(*row.reference_job);
    if (!source) throw Error(ErrorCode::WrongState, named(*row.reference_job) + " has been removed");
    // One that was asked for by its method must be as it was asked for; of a job that is named, whatever it left will
    // do.
    const bool enough = reference.is_object() ? source->state == JobState::Succeeded : is_over(source->state);
    if (enough && !source->film.empty()) return {{"film", (files.films / source->film).string()}};
    std::string fate = " ended without a film";
    if (source->state == JobState::Cancelled) fate = " was cancelled";
    if (source->state == JobState::Failed)
        fate = " failed: " + (source->failure.empty() ? "" : json::parse(source->failure).value("detail", ""));
    if (!is_over(source->state)) fate = " is not over";
    throw Error(ErrorCode::WrongState, named(source->seq) + fate);
}

void Service::Impl::fail_for_reference(JobRow row, const std::string& reason) {
    row.state = JobState::Failed;
    row.finished_ms = now_ms();
    row.failure = problem_json(ErrorCode::WrongState, reason, {}, "/v1/jobs/" + job_id(row.seq))
                      .dump(-1, ' ', false, json::error_handler_t::replace);
    commit_state(row, "failed: " + reason);
    queue.remove(row.seq);
    ended(row);
    spdlog::warn("job {} failed: {}", job_id(row.seq), reason);
}

void Service::Impl::release_waiting(const JobRow& over) {
    for (const int64_t seq : queue.release(over.seq)) {
        // Where this does not come through, the job is in the queue, and judged again when its turn comes.
        try {
            auto row = store.job(seq);
            if (!row || row->state != JobState::Queued) continue;
            try {
                reference_source(*row);
            } catch (const Error& error) {
                fail_for_reference(*std::move(row), error.what());
            }
        } catch (const std::exception& error) {
            spdlog::error("job {}: that its reference is over cannot be recorded yet: {}", job_id(seq), error.what());
        }
    }
}

void Service::Impl::check_unused(const JobRow& row, bool running) {
    for (const JobRow& user : store.unfinished_jobs_measured_against(row.seq))
        if (!running || user.state == JobState::Running)
            throw Error(ErrorCode::WrongState, "job " + job_id(row.seq) + " is the reference of job " +
                                                   job_id(user.seq) + ", which is " +
                                                   std::string(job_state_name(user.state)));
}

}  // namespace photond
