#pragma once
// The store's schema as a list of steps: step i leads from version i to i + 1. A step that has been released is never
// edited; a change is a new step.

#include <iterator>

namespace photond {

inline constexpr const char* kMigrations[] = {
    // 1: first light
    R"sql(
    CREATE TABLE meta (key TEXT PRIMARY KEY, value) WITHOUT ROWID;
    CREATE TABLE jobs (
        seq INTEGER PRIMARY KEY AUTOINCREMENT,
        state INTEGER NOT NULL, priority INTEGER NOT NULL,
        device TEXT NOT NULL, method TEXT NOT NULL, scene TEXT NOT NULL, request TEXT NOT NULL,
        created_ms INTEGER NOT NULL, started_ms INTEGER, finished_ms INTEGER,
        attempt INTEGER NOT NULL, crashes INTEGER NOT NULL, losses INTEGER NOT NULL,
        cancel_requested INTEGER NOT NULL, purge_requested INTEGER NOT NULL,
        passes_done INTEGER NOT NULL, progress REAL NOT NULL, seconds REAL NOT NULL,
        film TEXT NOT NULL, pixel_hash TEXT NOT NULL,
        statistics TEXT NOT NULL, failure TEXT NOT NULL, attempts TEXT NOT NULL);
    CREATE INDEX jobs_by_state ON jobs (state, seq);
    CREATE INDEX jobs_by_method ON jobs (method, state, seq);
    CREATE INDEX jobs_by_scene ON jobs (scene, state, seq);
    CREATE INDEX jobs_queue ON jobs (device, priority, seq) WHERE state = 0;
    CREATE INDEX jobs_to_purge ON jobs (seq) WHERE purge_requested = 1;
    CREATE TABLE labels (
        key TEXT NOT NULL, value TEXT NOT NULL, job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
        PRIMARY KEY (key, job)) WITHOUT ROWID;
    CREATE INDEX labels_by_value ON labels (key, value, job);
    CREATE INDEX labels_by_job ON labels (job);
    CREATE TABLE job_log (
        id INTEGER PRIMARY KEY, job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
        at_ms INTEGER NOT NULL, line TEXT NOT NULL);
    CREATE INDEX job_log_by_job ON job_log (job, id);
    CREATE TABLE keys (
        key TEXT PRIMARY KEY, body_sha256 TEXT NOT NULL, at_ms INTEGER NOT NULL,
        job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE) WITHOUT ROWID;
    CREATE INDEX keys_by_job ON keys (job);
    CREATE TABLE scenes (
        seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, name TEXT NOT NULL, file TEXT NOT NULL,
        summary TEXT NOT NULL, created_ms INTEGER NOT NULL);
    CREATE INDEX scenes_by_name ON scenes (name, seq);
    CREATE TABLE images (
        id TEXT PRIMARY KEY, media_type TEXT NOT NULL, file TEXT NOT NULL, width INTEGER NOT NULL,
        height INTEGER NOT NULL, channels INTEGER NOT NULL, bytes INTEGER NOT NULL, created_ms INTEGER NOT NULL);
    CREATE TABLE events (id INTEGER PRIMARY KEY, job INTEGER NOT NULL, type TEXT NOT NULL, data TEXT NOT NULL);
    CREATE INDEX events_by_job ON events (job, id);
    )sql",
    // 2: artefacts that methods leave beside the film
    R"sql(
    ALTER TABLE jobs ADD COLUMN artefacts TEXT NOT NULL DEFAULT '[]';
    CREATE INDEX jobs_with_artefacts ON jobs (seq) WHERE artefacts <> '[]';
    )sql",
    // 3: references, curves, comparisons
    R"sql(
    ALTER TABLE jobs ADD COLUMN role INTEGER NOT NULL DEFAULT 0;
    ALTER TABLE jobs ADD COLUMN content TEXT NOT NULL DEFAULT '';
    ALTER TABLE jobs ADD COLUMN reference_job INTEGER;
    ALTER TABLE jobs ADD COLUMN comparison INTEGER;
    ALTER TABLE jobs ADD COLUMN curve TEXT NOT NULL DEFAULT '';
    ALTER TABLE jobs ADD COLUMN error_now TEXT NOT NULL DEFAULT '';
    CREATE INDEX jobs_by_content ON jobs (content, seq) WHERE content <> '';
    CREATE INDEX jobs_by_reference ON jobs (reference_job, state) WHERE reference_job IS NOT NULL;
    CREATE TABLE comparisons (
        seq INTEGER PRIMARY KEY AUTOINCREMENT, scene TEXT NOT NULL, request TEXT NOT NULL, created_ms INTEGER NOT NULL,
        purge_requested INTEGER NOT NULL DEFAULT 0);
    CREATE TABLE comparison_jobs (
        comparison INTEGER NOT NULL REFERENCES comparisons (seq) ON DELETE CASCADE, place INTEGER NOT NULL,
        job INTEGER NOT NULL, label TEXT NOT NULL, parameters TEXT NOT NULL, seed INTEGER NOT NULL,
        PRIMARY KEY (comparison, place)) WITHOUT ROWID;
    CREATE INDEX comparison_jobs_by_job ON comparison_jobs (job);
    CREATE TABLE comparison_keys (
        key TEXT PRIMARY KEY, body_sha256 TEXT NOT NULL, at_ms INTEGER NOT NULL,
        comparison INTEGER NOT NULL REFERENCES comparisons (seq) ON DELETE CASCADE) WITHOUT ROWID;
    CREATE INDEX comparison_keys_by_comparison ON comparison_keys (comparison);
    )sql",
    // 4: layers of uploaded images
    R"sql(
    ALTER TABLE images ADD COLUMN layers TEXT NOT NULL DEFAULT '';
    )sql",
    // 5: what lists of jobs are filtered by and show, apart from all that makes a job's row long. The view is the one
    // place that says what that is; triggers keep it. Labels are JSON whose brace is a comma (store/job_lists.cpp).
    R"sql(
    CREATE VIEW jobs_summarized AS SELECT
        seq, state, role, device, method, scene, ',' || substr(json_extract(request, '$.labels'), 2) AS labels,
        priority, comparison, created_ms, started_ms, finished_ms, progress, passes_done, seconds, error_now,
        json_extract(request, '$.scene') AS scene_name,
        json_extract(request, '$.image.width') AS width, json_extract(request, '$.image.height') AS height,
        CASE failure WHEN '' THEN NULL ELSE json_extract(failure, '$.detail') END AS failure
        FROM jobs;
    CREATE TABLE job_summaries (
        seq INTEGER PRIMARY KEY REFERENCES jobs (seq) ON DELETE CASCADE,
        state INTEGER NOT NULL, role INTEGER NOT NULL, device TEXT NOT NULL, method TEXT NOT NULL, scene TEXT NOT NULL,
        labels TEXT, priority INTEGER NOT NULL, comparison INTEGER, created_ms INTEGER NOT NULL, started_ms INTEGER,
        finished_ms INTEGER, progress REAL NOT NULL, passes_done INTEGER NOT NULL, seconds REAL NOT NULL,
        error_now TEXT NOT NULL, scene_name TEXT, width INTEGER, height INTEGER, failure TEXT);
    INSERT INTO job_summaries SELECT * FROM jobs_summarized;
    CREATE INDEX job_summaries_filters ON job_summaries (seq, state, role, device, method, scene, labels);
    CREATE TRIGGER job_inserted AFTER INSERT ON jobs BEGIN
        INSERT INTO job_summaries SELECT * FROM jobs_summarized WHERE seq = new.seq;
    END;
    CREATE TRIGGER job_updated AFTER UPDATE ON jobs BEGIN
        INSERT OR REPLACE INTO job_summaries SELECT * FROM jobs_summarized WHERE seq = new.seq;
    END;
    DROP TABLE labels;
    )sql",
    // 6: orders of lists beside the newest first
    R"sql(
    CREATE INDEX job_summaries_waiting ON job_summaries (priority DESC, seq) WHERE state = 0;
    CREATE INDEX job_summaries_ended ON job_summaries (finished_ms DESC, seq DESC) WHERE finished_ms IS NOT NULL;
    )sql",
    // 7: jobs of comparisons that were repeated; of a repeat the job that was planned in its place
    R"sql(
    ALTER TABLE comparison_jobs ADD COLUMN repeat_of INTEGER;
    )sql",
    // 8: which store this is; and files that no row names yet or any more, which a start may therefore remove
    R"sql(
    INSERT INTO meta (key, value) VALUES ('store_id', lower(hex(randomblob(16))));
    CREATE TABLE unnamed_files (path TEXT PRIMARY KEY) WITHOUT ROWID;
    DROP INDEX jobs_with_artefacts;
    CREATE INDEX jobs_with_film ON jobs (film, artefacts) WHERE film <> '';
    )sql",
    // 9: references of two films
    R"sql(
    ALTER TABLE jobs ADD COLUMN second_reference_job INTEGER;
    CREATE INDEX jobs_by_second_reference ON jobs (second_reference_job, state)
        WHERE second_reference_job IS NOT NULL;
    )sql",
    // 10: bias and noise apart of the films of a comparison's row, by what those are called, and layer
    R"sql(
    CREATE TABLE row_biases (
        comparison INTEGER NOT NULL REFERENCES comparisons (seq) ON DELETE CASCADE, films TEXT NOT NULL,
        layer TEXT NOT NULL, errors TEXT NOT NULL, map TEXT NOT NULL,
        PRIMARY KEY (comparison, films, layer)) WITHOUT ROWID;
    )sql",
    // 11: sequences of frames: kept as comparisons are, a request and its jobs, by their kind
    R"sql(
    ALTER TABLE comparisons ADD COLUMN kind INTEGER NOT NULL DEFAULT 0;
    )sql",
    // 12: how far the frames of a sequence are, without reading one of them
    R"sql(
    CREATE INDEX job_summaries_of_groups ON job_summaries
        (comparison, state, progress, seconds, started_ms, finished_ms) WHERE comparison IS NOT NULL;
    )sql",
};

inline constexpr int kSchemaVersion = static_cast<int>(std::size(kMigrations));

}  // namespace photond
