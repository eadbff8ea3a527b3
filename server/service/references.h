#pragma once
// What jobs are measured against: other jobs, uploaded images, and renderings made for it once and kept by content.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/job.h"
#include "protocol/message_parts.h"
#include "server/service/prepared_job.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"

namespace photond {

/// All under the lock.
class References {
public:
    explicit References(ServiceCore& core) : core_(core) {}

    /// A reference that a method makes is so many films of different seeds, each of a part of the passes.
    static constexpr uint32_t kFilms = 2;

    /// The form of a reference and the SHA-256 of what one of its films shows and how it is made: two with the same are
    /// the same image. Films that were made before there were two carry no form and are not found by what they show.
    static std::string reference_content(const JobRequest& film, const std::string& scene_id);
    /// Whether that is the content of one of two films.
    static bool is_one_of_two(const std::string& content);
    /// One of the films that request.reference->rendering asks for, as a job of its own. `film` < kFilms is its seed
    /// less one. Of n passes each has n / 2, rounded up; half of the seconds; and twice the estimated error, which is a
    /// mean of squares, that is to be reached.
    static JobRequest reference_request(const JobRequest& request, uint32_t film);

    /// Without the lock: where the request's reference is to be rendered, all its films. Throws DeviceUnavailable.
    std::vector<JobRow> reference_films(const JobRequest& request, const std::string& scene) const;
    /// Of such films those that are missing, for insert_references(): where jobs of that content are there fills in
    /// `reference_jobs` and leaves none, else all. Nothing happens where there are none.
    void leave_missing(std::vector<JobRow>& films, std::vector<int64_t>& reference_jobs);
    /// Both; but where they were named before, by a job that goes on, they stay as long as they are there.
    std::vector<JobRow> missing_references(const JobRequest& request, const SceneRef& scene,
                                           std::vector<int64_t>& reference_jobs);
    /// Inside a transaction: for each the job of that content that is there by now, else this one, inserted. Their
    /// seqs.
    std::vector<int64_t> insert_references(const std::vector<JobRow>& references, Insertion& inserted);
    /// Inside a transaction: references of a job that wait with a lower priority than its own get that.
    void raise_references(const JobRow& job, Insertion& inserted);

    /// A job that is not over yet and that this one is measured against.
    std::optional<int64_t> waits_for(const JobRow& row);
    std::string waiting_text(const JobRow& row);  // for the log; empty when it does not wait
    /// What a job is measured against, once that is over; empty for a job without a reference. Throws WrongState, with
    /// the reason, where it is lost.
    std::optional<ReferenceSource> reference_source(const JobRow& row);
    /// Throws WrongState likewise, where one of its films is over and lost, though another may be still to come.
    void check_not_lost(const JobRow& row);
    /// Throws WrongState, naming one, while jobs that are not over are measured against this one; with `running` only
    /// those that run now count.
    void check_unused(const JobRow& row, bool running);
    /// Throws WrongState, naming one, while jobs of others than that comparison that are not over are measured against
    /// this one of its jobs.
    void check_unused_beside(int64_t seq, int64_t comparison);

private:
    /// One that is finished, or will be.
    std::optional<int64_t> usable_reference(const std::string& content);
    JobRow reference_row(const JobRequest& reference, const std::string& scene) const;
    int64_t insert_reference(const JobRow& reference, Insertion& inserted);
    void raise_reference(int64_t seq, int priority, Insertion& inserted);
    /// The film that a job left. `made`: for this job, by its method.
    std::filesystem::path film_of(int64_t seq, bool made);

    ServiceCore& core_;
};

}  // namespace photond
