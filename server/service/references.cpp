#include "server/service/references.h"

#include <algorithm>
#include <string_view>

#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"

namespace photond {

using nlohmann::json;

namespace {

/// Begins the content of each of two films.
constexpr std::string_view kOneOfTwo = "one of two films: ";

std::string named(int64_t seq) { return "its reference, job " + job_id(seq) + ","; }

Error in_use(int64_t seq, const JobRow& user) {
    return Error(ErrorCode::WrongState, "job " + job_id(seq) + " is the reference of job " + job_id(user.seq) +
                                            ", which is " + std::string(job_state_name(user.state)));
}

/// What is left to each film of a whole that is to stop there.
StopConditions part_of(StopConditions stop) {
    if (stop.passes) stop.passes = *stop.passes / References::kFilms + (*stop.passes % References::kFilms != 0);
    if (stop.seconds) stop.seconds = std::max(*stop.seconds / References::kFilms, StopConditions::kLeastSeconds);
    if (stop.target) stop.target->value = std::min(stop.target->value * References::kFilms, ErrorTarget::kGreatest);
    return stop;
}

}  // namespace

std::string References::reference_content(const JobRequest& film, const std::string& scene_id) {
    json canonical = naming_json(film);
    canonical.erase("priority"), canonical.erase("labels"), canonical.erase("quiet_machine");
    canonical["scene"] = scene_id;
    const std::string text = canonical.dump(-1, ' ', false, json::error_handler_t::replace);
    return std::string(kOneOfTwo) + sha256_hex(text.data(), text.size());
}

bool References::is_one_of_two(const std::string& content) { return content.starts_with(kOneOfTwo); }

JobRequest References::reference_request(const JobRequest& request, uint32_t film) {
    JobRequest reference = request;
    reference.method = request.reference->rendering->method;
    reference.stop = part_of(request.reference->rendering->stop);
    reference.reference.reset();
    reference.metrics.clear();
    reference.labels.clear();
    reference.quiet_machine.reset();  // nobody compares its clock
    reference.seed = 1 + film;
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

JobRow References::reference_row(const JobRequest& reference, const std::string& scene) const {
    JobRow row;
    row.role = JobRole::Reference;
    row.content = reference_content(reference, scene);
    row.priority = reference.priority;
    row.device = core_.device_of(reference.method, "/reference/method/device");
    row.method = reference.method.name;
    row.scene = scene;
    row.request = to_json(reference).dump();
    row.created_ms = now_ms();
    return row;
}

std::vector<JobRow> References::reference_films(const JobRequest& request, const std::string& scene) const {
    std::vector<JobRow> films;
    if (request.reference && request.reference->rendering)
        for (uint32_t film = 0; film < kFilms; ++film)
            films.push_back(reference_row(reference_request(request, film), scene));
    return films;
}

void References::leave_missing(std::vector<JobRow>& films, std::vector<int64_t>& reference_jobs) {
    std::vector<int64_t> found;
    for (const JobRow& film : films)
        if (const auto there = usable_reference(film.content)) found.push_back(*there);
    if (films.empty() || found.size() < films.size()) return;
    reference_jobs = std::move(found);
    films.clear();
}

std::vector<JobRow> References::missing_references(const JobRequest& request, const SceneRef& scene,
                                                   std::vector<int64_t>& reference_jobs) {
    if (!request.reference || !request.reference->rendering) return {};
    const auto stays = [&](int64_t seq) {
        const auto row = core_.store.job(seq);
        return row && !row->cancel_requested && row->state <= JobState::Succeeded;
    };
    if (!reference_jobs.empty() && std::all_of(reference_jobs.begin(), reference_jobs.end(), stays)) return {};
    std::vector<JobRow> films = reference_films(request, scene.id);
    leave_missing(films, reference_jobs);
    return films;
}

std::optional<int64_t> References::usable_reference(const std::string& content) {
    const auto found = core_.store.reference_of_content(content);
    if (!found || found->cancel_requested) return std::nullopt;  // it is about to be over, unfinished
    return found->seq;
}

int64_t References::insert_reference(const JobRow& film, Insertion& inserted) {
    if (const auto found = usable_reference(film.content)) return *found;
    JobRow reference = film;
    core_.store.insert_job(reference);
    core_.store.append_log(reference.seq, reference.created_ms,
                           "queued for " + reference.device + ", to be one of the two films of a reference");
    core_.put_event(inserted.outbox, "state", reference.seq, ServiceCore::state_data(reference));
    inserted.rows.push_back(reference);
    return reference.seq;
}

std::vector<int64_t> References::insert_references(const std::vector<JobRow>& references, Insertion& inserted) {
    std::vector<int64_t> seqs;
    seqs.reserve(references.size());
    for (const JobRow& reference : references) seqs.push_back(insert_reference(reference, inserted));
    return seqs;
}

void References::raise_references(const JobRow& job, Insertion& inserted) {
    for (const int64_t seq : job.reference_jobs) raise_reference(seq, job.priority, inserted);
}

void References::raise_reference(int64_t seq, int priority, Insertion& inserted) {
    const auto standing = core_.store.standing(seq);
    if (!standing || standing->role != JobRole::Reference || standing->state != JobState::Queued ||
        standing->priority >= priority)
        return;
    auto row = core_.store.job(seq);
    if (!row) return;
    row->priority = priority;
    core_.store.update_job(*row);
    core_.store.append_log(seq, now_ms(), "priority raised to " + std::to_string(priority) + ": a job needs it");
    core_.put_event(inserted.outbox, "state", seq, ServiceCore::state_data(*row));
    inserted.rows.push_back(*std::move(row));
}

std::optional<int64_t> References::waits_for(const JobRow& row) {
    for (const int64_t seq : row.reference_jobs)
        if (const auto reference = core_.store.standing(seq); reference && !is_over(reference->state)) return seq;
    return std::nullopt;
}

std::string References::waiting_text(const JobRow& row) {
    if (!waits_for(row)) return "";
    std::string jobs;
    for (const int64_t seq : row.reference_jobs) jobs += (jobs.empty() ? "" : " and ") + job_id(seq);
    return "; waits for its reference, job " + jobs;
}

std::optional<ReferenceSource> References::reference_source(const JobRow& row) {
    const json request = json::parse(row.request);
    const json reference = request.value("reference", json());
    if (reference.is_null()) return std::nullopt;
    if (reference.is_string() && reference.get_ref<const std::string&>().starts_with("image:")) {
        const auto image = core_.store.image(reference.get<std::string>().substr(6));
        if (!image) throw Error(ErrorCode::WrongState, "its reference, " + reference.get<std::string>() + ", is gone");
        return ReferenceSource{{.image = core_.files.images / image->file}, {}};
    }
    if (row.reference_jobs.empty()) throw Error(ErrorCode::WrongState, "its reference has been lost");
    ReferenceSource source{{.film = film_of(row.reference_jobs[0], reference.is_object())}, {}};
    if (row.reference_jobs.size() > 1)
        source.second = ImageSource{.film = film_of(row.reference_jobs[1], reference.is_object())};
    return source;
}

void References::check_not_lost(const JobRow& row) {
    if (!waits_for(row)) {
        reference_source(row);
        return;
    }
    const bool made = json::parse(row.request).value("reference", json()).is_object();
    for (const int64_t seq : row.reference_jobs)
        if (const auto film = core_.store.job(seq); !film || is_over(film->state)) film_of(seq, made);
}

std::filesystem::path References::film_of(int64_t seq, bool made) {
    const auto source = core_.store.job(seq);
    if (!source) throw Error(ErrorCode::WrongState, named(seq) + " has been removed");
    // One that was asked for by its method must be as it was asked for; of a job that is named, whatever it left will
    // do.
    const bool enough = made ? source->state == JobState::Succeeded : is_over(source->state);
    if (enough && !source->film.empty()) return core_.files.films / source->film;
    std::string fate = " ended without a film";
    if (source->state == JobState::Cancelled) fate = " was cancelled";
    if (source->state == JobState::Failed)
        fate = " failed: " + (source->failure.empty() ? "" : json::parse(source->failure).value("detail", ""));
    if (!is_over(source->state)) fate = " is not over";
    throw Error(ErrorCode::WrongState, named(seq) + fate);
}

void References::check_unused(const JobRow& row, bool running) {
    for (const JobRow& user : core_.store.unfinished_jobs_measured_against(row.seq))
        if (!running || user.state == JobState::Running) throw in_use(row.seq, user);
}

void References::check_unused_beside(int64_t seq, int64_t comparison) {
    for (const JobRow& user : core_.store.unfinished_jobs_measured_against(seq))
        if (user.comparison != comparison) throw in_use(seq, user);
}

}  // namespace photond
