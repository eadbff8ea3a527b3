#include "server/service/purges.h"

#include <vector>

#include "protocol/worker_messages.h"
#include "renderer/core/atomic_file.h"
#include "renderer/methods/registry.h"
#include "server/service/saved_film.h"

namespace photond {

void Purges::purge(const JobRow& row) {
    auto transaction = core_.store.transaction();
    core_.store.delete_job(row.seq);
    note_removal(row.film);
    transaction.commit();
    core_.artefacts.forget("job/" + std::to_string(row.seq) + "/");
    remove_film(row.film);
    finish_purges();
}

void Purges::remove_parts(const std::string& film) const {
    remove_quietly(AtomicFile::part_of(core_.files.films / film));
    for (const ArtefactInfo& artefact : all_artefacts())
        remove_quietly(AtomicFile::part_of(artefact_path(core_.files.films / film, artefact.name)));
}

void Purges::note_removal(const std::string& film) {
    if (!film.empty()) core_.store.note_unnamed_file(path_of_film(film));
}

void Purges::remove_film(const std::string& film) {
    if (film.empty()) return;
    remove_quietly(core_.files.films / film);
    for (const ArtefactInfo& artefact : all_artefacts())
        remove_quietly(artefact_path(core_.files.films / film, artefact.name));
    core_.store.unnamed_file_is_gone(path_of_film(film));
}

void Purges::finish_purge(const ComparisonRow& row) {
    std::vector<RemovableJob> removed;
    {
        auto transaction = core_.store.transaction();
        bool empty = true;
        for (RemovableJob& job : core_.store.removable_jobs(row.seq)) {
            if (!is_over(job.state)) {  // goes when its worker has let go of it, and the comparison with the last one
                empty = false;
                continue;
            }
            core_.store.delete_job(job.seq);
            note_removal(job.film);
            removed.push_back(std::move(job));
        }
        if (empty) core_.store.delete_comparison(row.seq);
        transaction.commit();
    }
    for (const RemovableJob& job : removed) {
        core_.artefacts.forget("job/" + std::to_string(job.seq) + "/");
        remove_film(job.film);
    }
    core_.artefacts.forget("comparison/" + std::to_string(row.seq) + "/");
}

void Purges::finish_purges() {
    for (const ComparisonRow& row : core_.store.comparisons_to_purge()) finish_purge(row);
}

void Purges::check_not_compared(const JobRow& row) {
    if (!row.comparison || !core_.store.comparison(*row.comparison)) return;
    const bool frame = row.role == JobRole::Frame;
    throw Error(ErrorCode::WrongState,
                "job " + job_id(row.seq) + " belongs to " + (frame ? "sequence " : "comparison ") +
                    group_id(frame ? GroupKind::Sequence : GroupKind::Comparison, *row.comparison) +
                    "; it is removed with that");
}

}  // namespace photond
