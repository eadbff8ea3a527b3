// The store keeps what it was told, across reopening, under one owner, and finds it quickly.
#include "server/store/store.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <fstream>
#include <new>

#include "protocol/error.h"
#include "server/store/artefact_cache.h"
#include "server/store/data_files.h"
#include "server/store/schema.h"

namespace photond {
namespace {

namespace fs = std::filesystem;

struct TemporaryFolder {
    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "photond-store-XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~TemporaryFolder() { fs::remove_all(path); }
    fs::path path;
};

JobRow some_job(const std::string& scene = "s", JobState state = JobState::Queued) {
    JobRow row;
    row.state = state;
    row.device = "cpu";
    row.method = "path_tracing";
    row.scene = scene;
    row.request = "{}";
    row.created_ms = 1'000;
    return row;
}

int64_t insert(Store& store, JobRow row, const std::vector<std::pair<std::string, std::string>>& labels = {}) {
    auto transaction = store.transaction();
    store.insert_job(row, labels);
    transaction.commit();
    return row.seq;
}

TEST(Store, AQueuedJobWaitsForItsReferenceUntilThatIsOver) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    JobRow reference = some_job("s", JobState::Running);
    reference.role = JobRole::Reference;
    reference.seq = insert(store, reference);
    JobRow job = some_job();
    job.reference_job = reference.seq;
    const int64_t seq = insert(store, job);
    ASSERT_EQ(store.queued_jobs().size(), 1u);
    EXPECT_EQ(store.queued_jobs()[0].waits_for, reference.seq);
    JobQuery query;
    query.role = JobRole::Reference;
    ASSERT_EQ(store.jobs(query).size(), 1u);
    EXPECT_EQ(store.jobs(query)[0].seq, reference.seq);
    auto transaction = store.transaction();
    reference.state = JobState::Failed;
    store.update_job(reference);
    EXPECT_EQ(store.queued_jobs()[0].waits_for, std::nullopt);
    store.delete_job(reference.seq);
    transaction.commit();
    EXPECT_EQ(store.queued_jobs()[0].seq, seq);
    EXPECT_EQ(store.queued_jobs()[0].waits_for, std::nullopt) << "of one that is gone nothing can be waited for";
}

TEST(Store, AJobComesBackAsItWasAfterReopening) {
    const TemporaryFolder folder;
    JobRow row = some_job("scene", JobState::Failed);
    row.priority = -7;
    row.started_ms = 5;
    row.attempt = 3;
    row.crashes = 1;
    row.losses = 2;
    row.cancel_requested = row.purge_requested = true;
    row.passes_done = 1'000'000'007;
    row.progress = 0.25;
    row.seconds = 1.5;
    row.film = "J1-3.film";
    row.pixel_hash = "ab";
    row.statistics = R"({"x":1})";
    row.failure = R"({"code":"no_space"})";
    row.attempts = R"([{"attempt":3}])";
    row.artefacts = R"(["photon_map.glb"])";
    int64_t seq = 0;
    {
        Store store(folder.path / "s");
        seq = insert(store, some_job());
        row.seq = seq;
        auto transaction = store.transaction();
        store.update_job(row);
        transaction.commit();
    }
    Store store(folder.path / "s");
    const auto found = store.job(seq);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->state, JobState::Failed);
    EXPECT_EQ(found->priority, -7);
    EXPECT_EQ(found->started_ms, 5);
    EXPECT_FALSE(found->finished_ms);
    EXPECT_EQ(found->attempt, 3);
    EXPECT_EQ(found->crashes, 1);
    EXPECT_EQ(found->losses, 2);
    EXPECT_TRUE(found->cancel_requested && found->purge_requested);
    EXPECT_EQ(found->passes_done, 1'000'000'007);
    EXPECT_EQ(found->progress, 0.25);
    EXPECT_EQ(found->seconds, 1.5);
    EXPECT_EQ(found->film, "J1-3.film");
    EXPECT_EQ(found->pixel_hash, "ab");
    EXPECT_EQ(found->statistics, R"({"x":1})");
    EXPECT_EQ(found->failure, R"({"code":"no_space"})");
    EXPECT_EQ(found->attempts, R"([{"attempt":3}])");
    EXPECT_EQ(found->artefacts, R"(["photon_map.glb"])");
    EXPECT_EQ(store.artefacts(), (std::vector<std::pair<std::string, std::string>>{{row.film, row.artefacts}}));
    EXPECT_EQ(store.jobs_to_purge().size(), 1u);
    EXPECT_EQ(store.integrity(), "ok");
}

TEST(Store, WhatIsNotCommittedIsNotThere) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    {
        auto transaction = store.transaction();
        JobRow row = some_job();
        store.insert_job(row, {{"a", "b"}});
        store.insert_key("key", "hash", row.seq, 1);
    }
    EXPECT_TRUE(store.jobs({}).empty());
    EXPECT_FALSE(store.key("key"));
    insert(store, some_job());  // the connection is usable after the rollback
    EXPECT_EQ(store.jobs({}).size(), 1u);
}

TEST(Store, AJobNumberIsNeverUsedTwice) {
    const TemporaryFolder folder;
    int64_t first = 0;
    {
        Store store(folder.path / "s");
        first = insert(store, some_job());
        auto transaction = store.transaction();
        store.insert_key("key", "hash", first, 1);
        store.append_log(first, 1, "line");
        store.delete_job(first);
        transaction.commit();
        EXPECT_FALSE(store.key("key")) << "a purged job's key would name a job that is not there";
        EXPECT_TRUE(store.log(first).empty());
    }
    Store store(folder.path / "s");
    EXPECT_GT(insert(store, some_job()), first);
}

TEST(Store, ListsByEveryFilterNewestFirstAndByPages) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    const int64_t a = insert(store, some_job("x"), {{"study", "one"}});
    const int64_t b = insert(store, some_job("y", JobState::Succeeded), {{"study", "two"}});
    const int64_t c = insert(store, some_job("x", JobState::Succeeded));
    const auto found = [&](const JobQuery& query) {
        std::vector<int64_t> seqs;
        for (const JobRow& row : store.jobs(query)) seqs.push_back(row.seq);
        return seqs;
    };
    using Seqs = std::vector<int64_t>;
    JobQuery query;
    EXPECT_EQ(found(query), (Seqs{c, b, a}));
    query.limit = 2;
    EXPECT_EQ(found(query), (Seqs{c, b}));
    query.before = b;
    EXPECT_EQ(found(query), (Seqs{a}));
    query = {};
    query.state = JobState::Succeeded;
    EXPECT_EQ(found(query), (Seqs{c, b}));
    query.scene = "x";
    EXPECT_EQ(found(query), (Seqs{c}));
    query = {};
    query.label_key = "study";
    EXPECT_EQ(found(query), (Seqs{b, a}));
    query.label_value = "one";
    EXPECT_EQ(found(query), (Seqs{a}));
    query = {};
    query.method = "other";
    EXPECT_TRUE(found(query).empty());
    EXPECT_EQ(store.unfinished_jobs_of_scene("x"), 1);
}

TEST(Store, EventsAreFoundByNumberAndByJobAndTheOldestForgotten) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    {
        auto transaction = store.transaction();
        for (uint64_t id = 1; id <= 10; ++id) store.insert_event({id, "state", "", "{}"}, id % 2 ? 1 : 2);
        store.set_event_ids_until(100);
        transaction.commit();
    }
    EXPECT_EQ(store.events(3, 100, 0, 100).size(), 7u);
    EXPECT_EQ(store.events(3, 6, 0, 100).size(), 2u);
    EXPECT_EQ(store.events(0, UINT64_MAX, 2, 3).size(), 3u);
    EXPECT_EQ(store.events(0, 100, 1, 1).front().job, "J1");
    EXPECT_TRUE(store.events(UINT64_MAX, UINT64_MAX, 0, 100).empty());
    {
        auto transaction = store.transaction();
        store.prune_events(4);
        transaction.commit();
    }
    EXPECT_EQ(store.events(0, 100, 0, 100).front().id, 7u);
    EXPECT_EQ(store.event_ids_until(), 100u);
}

TEST(Store, RefusesANewerSchemaAndADamagedFile) {
    const TemporaryFolder folder;
    {
        Database database(folder.path / "new", nullptr, 0);
        database.execute("PRAGMA user_version = 1000");
    }
    EXPECT_THROW(Store(folder.path / "new"), Error);
    std::ofstream(folder.path / "bad") << std::string(8192, 'x');
    EXPECT_THROW(Store(folder.path / "bad"), Error);
}

TEST(Store, AStoreOfTheFirstVersionIsCarriedOn) {
    const TemporaryFolder folder;
    {
        Database first(folder.path / "s", kMigrations, 1);
        first.execute(
            "INSERT INTO jobs VALUES (7, 2, 0, 'cpu', 'path_tracing', 's', '{}', 1, 2, 3, 1, 0, 0, 0, 0, 4, 1, 0.5, "
            "'J7-1.film', 'ab', '', '', '[]')");
    }
    Store store(folder.path / "s");
    const auto job = store.job(7);
    ASSERT_TRUE(job);
    EXPECT_EQ(job->film, "J7-1.film");
    EXPECT_EQ(job->artefacts, "[]");
    EXPECT_TRUE(store.artefacts().empty());
    JobRow row = *job;
    row.artefacts = R"(["photon_map.glb"])";
    auto transaction = store.transaction();
    store.update_job(row);
    transaction.commit();
    EXPECT_EQ(store.artefacts(),
              (std::vector<std::pair<std::string, std::string>>{{"J7-1.film", R"(["photon_map.glb"])"}}));
}

TEST(Store, HasOneOwner) {
    const TemporaryFolder folder;
    const DataFiles first(folder.path / "data");
    EXPECT_THROW(DataFiles(folder.path / "data"), Error);
}

TEST(Store, JobIdsAreReadStrictly) {
    EXPECT_EQ(job_seq(job_id(17)), 17);
    for (const char* wrong : {"", "J", "J0", "J01", "J-1", "J1x", "j1", "17", "J 1", "J99999999999999999999"})
        EXPECT_EQ(job_seq(wrong), 0) << wrong;
}

TEST(DataFiles, ATreesHashDependsOnNamesAndContentsOnly) {
    const TemporaryFolder folder;
    const auto write = [&](const fs::path& file, const std::string& text) {
        fs::create_directories((folder.path / file).parent_path());
        std::ofstream(folder.path / file) << text;
    };
    const auto hash = [&](const char* root) {
        return hash_tree(folder.path / root, list_tree(folder.path / root, 10));
    };
    write("a/x.gltf", "1"), write("a/t/y.bin", "2");
    write("b/t/y.bin", "2"), write("b/x.gltf", "1");
    write("c/x.gltf", "2"), write("c/t/y.bin", "1");
    EXPECT_EQ(hash("a"), hash("b"));
    EXPECT_NE(hash("a"), hash("c"));
    EXPECT_THROW(list_tree(folder.path / "a", 1), Error);
    fs::create_symlink("/etc/passwd", folder.path / "a/link");
    EXPECT_THROW(list_tree(folder.path / "a", 10), Error);
}

TEST(ArtefactCache, MakesOnceKeepsWhileUsedAndForgetsTheOldest) {
    const TemporaryFolder folder;
    ArtefactCache cache(10);
    int made = 0;
    const auto get = [&](const std::string& key) {
        return cache.get(key, folder.path / std::to_string(made), [&](const fs::path& path) {
            ++made;
            std::ofstream(path) << "123456";
            return std::map<std::string, std::string>{{"h", "v"}};
        });
    };
    auto a = get("a");
    EXPECT_EQ(get("a"), a);
    EXPECT_EQ(made, 1);
    EXPECT_EQ(a->bytes, 6u);
    EXPECT_EQ(a->headers.at("h"), "v");
    get("b");  // 12 bytes are over the limit: "a" goes, but we still hold it
    EXPECT_TRUE(fs::exists(a->path));
    const fs::path path = a->path;
    a.reset();
    EXPECT_FALSE(fs::exists(path));
    EXPECT_THROW(cache.get("c", folder.path / "c",
                           [](const fs::path&) -> std::map<std::string, std::string> { throw std::bad_alloc(); }),
                 std::bad_alloc);
    get("c");  // a failure leaves nothing behind that others would wait for
    cache.forget("c");
    const int before = made;
    get("c");
    EXPECT_EQ(made, before + 1);
}

TEST(StoreLong, AHundredThousandJobs) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    {
        auto transaction = store.transaction();
        for (int i = 0; i < 100'000; ++i) {
            JobRow row = some_job(i % 7 ? "s" : "t", static_cast<JobState>(i % 5));
            row.request = row.statistics = "{\"filler\":\"" + std::string(1000, 'x') + "\"}";
            store.insert_job(row, {{"n", std::to_string(i % 100)}});
        }
        transaction.commit();
    }
    JobQuery query;
    query.scene = "t";
    query.state = JobState::Queued;
    query.label_key = "n";
    query.label_value = "35";
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EQ(store.jobs(query).size(), 100u);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
    RecordProperty("filtered_page_seconds", std::to_string(spent.count()));
    EXPECT_EQ(store.queued_jobs().size(), 20'000u);
}

}  // namespace
}  // namespace photond
