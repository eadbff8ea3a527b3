// The store keeps what it was told, across reopening, under one owner, and finds it quickly.
#include "server/store/store.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <map>
#include <new>
#include <nlohmann/json.hpp>

#include "protocol/error.h"
#include "server/store/artefact_cache.h"
#include "server/store/data_files.h"
#include "server/store/schema.h"

namespace photond::store_test {
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

using Labels = std::map<std::string, std::string>;

JobRow labelled(JobRow row, const Labels& labels) {
    row.request = nlohmann::json{{"labels", labels}}.dump();
    return row;
}

int64_t insert(Store& store, JobRow row) {
    auto transaction = store.transaction();
    store.insert_job(row);
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
    job.reference_jobs = {reference.seq};
    const int64_t seq = insert(store, job);
    ASSERT_EQ(store.queued_jobs().size(), 1u);
    EXPECT_EQ(store.queued_jobs()[0].waits_for, reference.seq);
    JobQuery query;
    query.role = JobRole::Reference;
    EXPECT_EQ(store.job_page(query), std::vector{reference.seq});
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
    EXPECT_EQ(store.films(), (std::vector<FilmRow>{{row.seq, row.film, row.artefacts}}));
    EXPECT_EQ(store.jobs_to_purge().size(), 1u);
    EXPECT_EQ(store.database().integrity(), "ok");
}

TEST(Store, WhatIsNotCommittedIsNotThere) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    {
        auto transaction = store.transaction();
        JobRow row = some_job();
        store.insert_job(row);
        store.insert_key("key", "hash", row.seq, 1);
    }
    EXPECT_TRUE(store.job_page({}).empty());
    EXPECT_FALSE(store.key("key"));
    insert(store, some_job());  // the connection is usable after the rollback
    EXPECT_EQ(store.job_page({}).size(), 1u);
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
    const int64_t a = insert(store, labelled(some_job("x"), {{"study", "one"}}));
    const int64_t b = insert(store, labelled(some_job("y", JobState::Succeeded), {{"study", "two"}}));
    const int64_t c = insert(store, some_job("x", JobState::Succeeded));
    JobRow other = some_job("z", JobState::Failed);
    other.device = "gpu:0";
    other.method = "photon_mapping";
    other.role = JobRole::Reference;
    const int64_t d = insert(store, other);
    using Seqs = std::vector<int64_t>;
    // Whether or not the whole list is known already, it is the same page; the total is that of all its pages.
    const auto found = [&](const JobQuery& query, int64_t total) {
        {
            auto transaction = store.transaction();
            store.update_job(*store.job(a));  // a change, however small: lists that were known are not any more
            transaction.commit();
        }
        const Seqs page = store.job_page(query);
        EXPECT_EQ(store.count_jobs(query), total);
        EXPECT_EQ(store.job_page(query), page);
        return page;
    };
    JobQuery query;
    EXPECT_EQ(found(query, 4), (Seqs{d, c, b, a}));
    query.limit = 2;
    EXPECT_EQ(found(query, 4), (Seqs{d, c}));
    query.before = c;
    EXPECT_EQ(found(query, 4), (Seqs{b, a}));
    query.offset = 1;
    EXPECT_EQ(found(query, 4), (Seqs{a}));
    query.before = INT64_MAX;
    EXPECT_EQ(found(query, 4), (Seqs{c, b}));
    query.offset = 4;
    EXPECT_EQ(found(query, 4), Seqs());
    query = {};
    query.states = {JobState::Succeeded};
    EXPECT_EQ(found(query, 2), (Seqs{c, b}));
    query.states = {JobState::Queued, JobState::Failed};
    EXPECT_EQ(found(query, 2), (Seqs{d, a}));
    query.states = {JobState::Succeeded};
    query.scene = "x";
    EXPECT_EQ(found(query, 1), (Seqs{c}));
    query = {};
    query.label_key = "study";
    EXPECT_EQ(found(query, 2), (Seqs{b, a}));
    query.label_value = "one";
    EXPECT_EQ(found(query, 1), (Seqs{a}));
    query = {};
    query.device = "gpu:0";
    EXPECT_EQ(found(query, 1), (Seqs{d}));
    query.device = "gpu:1";
    EXPECT_EQ(found(query, 0), Seqs());
    query = {};
    query.role = JobRole::Reference;
    query.method = "photon_mapping";
    EXPECT_EQ(found(query, 1), (Seqs{d}));
    query.method = "other";
    EXPECT_EQ(found(query, 0), Seqs());
    EXPECT_EQ(store.unfinished_jobs_of_scene("x"), 1);
}

TEST(Store, ALabelIsFoundByAllOfItAndNothingElseIsTakenForIt) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    // Texts that would be found if they were put together carelessly: with each other's parts, and with what JSON
    // is written with.
    const std::vector<Labels> all{{{"a", "b"}},
                                  {{"a", "bc"}},
                                  {{"xa", "b"}},
                                  {{"x", "a\":\"b"}, {"y", "{\"a\":\"b\"}"}},
                                  {{"x\"a", "b"}, {",\"a", "b"}, {"x,\"a", "b"}},
                                  {{"a\\", "b"}, {"a", "b\\"}},
                                  {{"\n\x1f", "\t"}},
                                  {{"größe", "ü"}},
                                  {{"A", "B"}},
                                  {{"", ""}},
                                  {}};
    std::vector<int64_t> seqs;
    for (const Labels& labels : all) seqs.push_back(insert(store, labelled(some_job(), labels)));
    const auto expect_found = [&](const JobQuery& query, const auto& has) {
        std::vector<int64_t> expected, found;
        for (size_t i = all.size(); i-- > 0;)
            if (has(all[i])) expected.push_back(seqs[i]);
        found = store.job_page(query);
        EXPECT_EQ(found, expected) << query.label_key << " = " << query.label_value.value_or("any");
    };
    for (const Labels& wanted : all)
        for (const auto& [key, value] : wanted) {
            if (key.empty()) continue;  // asks for no label; no request may have one
            JobQuery query;
            query.label_key = key;
            expect_found(query, [&](const Labels& labels) { return labels.count(key) > 0; });
            query.label_value = value;
            expect_found(query, [&](const Labels& labels) { return labels.count(key) && labels.at(key) == value; });
        }
    for (size_t i = 0; i < all.size(); ++i)
        EXPECT_EQ(nlohmann::json::parse(store.job_summary(seqs[i])->labels), nlohmann::json(all[i]));
}

TEST(Store, ASummaryFollowsItsJob) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    JobRow row = some_job("0123");
    row.request =
        R"({"scene":"box","image":{"width":64,"height":48},"method":{"name":"path_tracing"},"labels":{"k":"v"}})";
    row.priority = 3;
    row.comparison = 9;
    row.seq = insert(store, row);
    const auto summary = [&] { return store.job_summary(row.seq).value(); };
    EXPECT_EQ(summary().seq, row.seq);
    EXPECT_EQ(summary().state, JobState::Queued);
    EXPECT_EQ(summary().scene, "box");
    EXPECT_EQ(summary().width, 64);
    EXPECT_EQ(summary().height, 48);
    EXPECT_EQ(summary().labels, R"({"k":"v"})");
    EXPECT_EQ(summary().priority, 3);
    EXPECT_EQ(summary().comparison, 9);
    EXPECT_EQ(summary().started_ms, std::nullopt);
    EXPECT_EQ(summary().failure, "");
    row.state = JobState::Failed;
    row.priority = -7;
    row.started_ms = 2'000;
    row.finished_ms = 3'000;
    row.progress = 0.5;
    row.passes_done = 12;
    row.seconds = 1.25;
    row.error_now = R"({"metric":"rmse","value":1})";
    row.failure = R"({"code":"timed_out","detail":"passed the limit of \"1\" s"})";
    auto transaction = store.transaction();
    store.update_job(row);
    EXPECT_EQ(summary().state, JobState::Failed);
    EXPECT_EQ(summary().priority, -7);
    EXPECT_EQ(summary().started_ms, row.started_ms);
    EXPECT_EQ(summary().finished_ms, row.finished_ms);
    EXPECT_EQ(summary().progress, 0.5);
    EXPECT_EQ(summary().passes_done, 12);
    EXPECT_EQ(summary().seconds, 1.25);
    EXPECT_EQ(summary().error_now, row.error_now);
    EXPECT_EQ(summary().failure, "passed the limit of \"1\" s");
    store.delete_job(row.seq);
    EXPECT_FALSE(store.job_summary(row.seq));
    transaction.commit();
    EXPECT_EQ(store.database().integrity(), "ok");
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
            "INSERT INTO jobs VALUES (7, 2, 0, 'cpu', 'path_tracing', 's', "
            "'{\"image\":{\"width\":5},\"labels\":{\"study\":\"a\"}}', 1, 2, 3, 1, 0, 0, 0, 0, 4, 1, 0.5, "
            "'J7-1.film', 'ab', '', '', '[]')");
    }
    Store store(folder.path / "s");
    const auto job = store.job(7);
    ASSERT_TRUE(job);
    EXPECT_EQ(job->film, "J7-1.film");
    EXPECT_EQ(job->artefacts, "[]");
    EXPECT_EQ(store.films(), (std::vector<FilmRow>{{7, "J7-1.film", "[]"}}));
    JobQuery by_label;
    by_label.label_key = "study";
    EXPECT_EQ(store.job_page(by_label), std::vector<int64_t>{7});
    EXPECT_EQ(store.job_summary(7)->width, 5);
    JobRow row = *job;
    row.artefacts = R"(["photon_map.glb"])";
    auto transaction = store.transaction();
    store.update_job(row);
    transaction.commit();
    EXPECT_EQ(store.films(), (std::vector<FilmRow>{{7, "J7-1.film", R"(["photon_map.glb"])"}}));
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

// The lists that a person looks at stay quick whatever the filter and wherever in the list: judged by the processor's
// time, which others on the machine do not change.
TEST(StoreLong, AHundredThousandJobs) {
    const TemporaryFolder folder;
    Store store(folder.path / "s");
    {
        auto transaction = store.transaction();
        for (int i = 0; i < 100'000; ++i) {
            JobRow row = labelled(some_job(i % 7 ? "s" : "t", static_cast<JobState>(i % 5)),
                                  {{"n", std::to_string(i % 100)}, {"study", "all of them"}});
            row.statistics = row.curve = "{\"filler\":\"" + std::string(5000, 'x') + "\"}";
            store.insert_job(row);
        }
        transaction.commit();
    }
    EXPECT_EQ(store.queued_jobs().size(), 20'000u);
    JobQuery narrow, wide, nothing, deep;
    narrow.scene = "t";
    narrow.states = {JobState::Queued};
    narrow.label_key = "n";
    narrow.label_value = "35";
    wide.label_key = "study";
    wide.states = {JobState::Succeeded, JobState::Failed};
    nothing.label_key = "study";
    nothing.label_value = "none";
    deep.offset = 99'000;
    deep.limit = 1000;
    const std::vector<std::pair<JobQuery, size_t>> queries{{narrow, 100}, {wide, 100}, {nothing, 0}, {deep, 1000}};
    std::vector<double> spent_ms;
    for (int round = 0; round < 25; ++round)
        for (const auto& [query, size] : queries) {
            const clock_t begun = std::clock();
            store.count_jobs(query);
            const std::vector<int64_t> page = store.job_page(query);
            ASSERT_EQ(page.size(), size);
            for (const int64_t seq : page) ASSERT_TRUE(store.job_summary(seq));
            spent_ms.push_back(1000.0 * static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC);
        }
    std::sort(spent_ms.begin(), spent_ms.end());
    RecordProperty("page_and_total_ms_p99", std::to_string(spent_ms[98]));
    EXPECT_LT(spent_ms[98], 50);
}

}  // namespace
}  // namespace photond::store_test
