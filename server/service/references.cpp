#include "server/service/references.h"

#include <algorithm>

#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"

namespace photond {

using nlohmann::json;

namespace {

std::string named(int64_t seq) { return "its reference, job " + job_id(seq) + ","; }

}  // namespace

std::string References::reference_content(const JobRequest& reference, const std::string& scene_id) {
    json canonical = to_json(reference);
    canonical.erase("priority"), canonical.erase("labels"), canonical.erase("quiet_machine");
    canonical["scene"] = scene_id;
    const std::string text = canonical.dump(-1, ' ', false, json::error_handler_t::replace);
    return sha256_hex(text.data(), text.size());
}

JobRequest References::reference_request(const JobRequest& request) {
    JobRequest reference = request;
    reference.method = request.reference->rendering->method;
    reference.stop = request.reference->rendering->stop;
    reference.reference.reset();
    reference.metrics.clear();
    reference.labels.clear();
    reference.quiet_machine.reset();  // nobody compares its clock
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

std::optional<JobRow> References::missing_reference(const JobRequest& request, const SceneRef& scene,
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
    row.device = core_.device_of(reference.method, "/reference/method/device");
    row.method = reference.method.name;
    row.scene = scene.id;
    row.request = to_json(reference).dump();
    row.created_ms = now_ms();
    return row;
}

std::optional<JobRow> References::usable_reference(const std::string& content) {
    auto found = core_.store.reference_of_content(content);
    if (found && found->cancel_requested) return std::nullopt;  // it is about to be over, unfinished
    return found;
}

int64_t References::insert_reference(JobRow reference, Insertion& inserted) {
    if (const auto found = usable_reference(reference.content)) return found->seq;
    core_.store.insert_job(reference);
    core_.store.append_log(reference.seq, reference.created_ms,
                           "queued for " + reference.device + ", to be a reference");
    core_.put_event(inserted.outbox, "state", reference.seq, ServiceCore::state_data(reference));
    inserted.rows.push_back(reference);
    return reference.seq;
}

void References::raise_reference(int64_t seq, int priority, Insertion& inserted) {
    auto row = core_.store.job(seq);
    if (!row || row->role != JobRole::Reference || row->state != JobState::Queued || row->priority >= priority) return;
    row->priority = priority;
    core_.store.update_job(*row);
    core_.store.append_log(seq, now_ms(), "priority raised to " + std::to_string(priority) + ": a job needs it");
    core_.put_event(inserted.outbox, "state", seq, ServiceCore::state_data(*row));
    inserted.rows.push_back(*std::move(row));
}

std::optional<int64_t> References::waits_for(const JobRow& row) {
    if (!row.reference_job) return std::nullopt;
    const auto reference = core_.store.job(*row.reference_job);
    if (!reference || is_over(reference->state)) return std::nullopt;
    return reference->seq;
}

std::string References::waiting_text(const JobRow& row) {
    const auto seq = waits_for(row);
    return seq ? "; waits for its reference, job " + job_id(*seq) : "";
}

std::optional<ImageSource> References::reference_source(const JobRow& row) {
    const json request = json::parse(row.request);
    const json reference = request.value("reference", json());
    if (reference.is_null()) return std::nullopt;
    if (reference.is_string() && reference.get_ref<const std::string&>().starts_with("image:")) {
        const auto image = core_.store.image(reference.get<std::string>().substr(6));
        if (!image) throw Error(ErrorCode::WrongState, "its reference, " + reference.get<std::string>() + ", is gone");
        return ImageSource{.image = core_.files.images / image->file};
    }
    if (!row.reference_job) throw Error(ErrorCode::WrongState, "its reference has been lost");
    const auto source = core_.store.job(*row.reference_job);
    if (!source) throw Error(ErrorCode::WrongState, named(*row.reference_job) + " has been removed");
    // One that was asked for by its method must be as it was asked for; of a job that is named, whatever it left will
    // do.
    const bool enough = reference.is_object() ? source->state == JobState::Succeeded : is_over(source->state);
    if (enough && !source->film.empty()) return ImageSource{.film = core_.files.films / source->film};
    std::string fate = " ended without a film";
    if (source->state == JobState::Cancelled) fate = " was cancelled";
    if (source->state == JobState::Failed)
        fate = " failed: " + (source->failure.empty() ? "" : json::parse(source->failure).value("detail", ""));
    if (!is_over(source->state)) fate = " is not over";
    throw Error(ErrorCode::WrongState, named(source->seq) + fate);
}

void References::check_unused(const JobRow& row, bool running) {
    for (const JobRow& user : core_.store.unfinished_jobs_measured_against(row.seq))
        if (!running || user.state == JobState::Running)
            throw Error(ErrorCode::WrongState, "job " + job_id(row.seq) + " is the reference of job " +
                                                   job_id(user.seq) + ", which is " +
                                                   std::string(job_state_name(user.state)));
}

}  // namespace photond
