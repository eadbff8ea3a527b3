// A store of an older version is brought up to date, and loses nothing, whenever the process is killed meanwhile.

#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>

#include "server/store/schema.h"
#include "server/store/store.h"

namespace photond::store_migration_test {
namespace {

namespace fs = std::filesystem;

constexpr int kOldVersion = 8;  // the last one without references of two films
constexpr int kOldJobs = 60;

struct TemporaryFolder {
    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "photond-migration-XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~TemporaryFolder() { fs::remove_all(path); }
    fs::path path;
};

/// A store of that version, as a daemon left it: with jobs, references, films, a comparison, scenes, images, events.
void make_old_store(const fs::path& file, int version) {
    Database store(file, kMigrations, version);
    Database::Transaction transaction(store);
    for (int seq = 1; seq <= kOldJobs; ++seq) {
        const std::string number = std::to_string(seq);
        const bool is_over = seq % 4 != 0;
        store.execute(
            ("INSERT INTO jobs (seq, state, priority, device, method, scene, request, created_ms, started_ms, "
             "finished_ms, attempt, crashes, losses, cancel_requested, purge_requested, passes_done, "
             "progress, seconds, film, pixel_hash, statistics, failure, attempts) VALUES (" +
             number + ", " + (is_over ? "2" : "0") + ", 0, 'cpu', 'path_tracing', 's', " +
             R"('{"scene":"box","image":{"width":64,"height":48},"labels":{"study":"a"}}', 1, 2, )" +
             (is_over ? "3" : "NULL") + ", 1, 0, 0, 0, 0, 4, 1, 0.5, 'J" + number + "-1.film', 'ab', '" +
             std::string(is_over ? 1500 : 0, 'x') + "', '', '[]')")
                .c_str());
        store.execute(("INSERT INTO events VALUES (" + number + ", " + number + ", 'state', '{}')").c_str());
        store.execute(("INSERT INTO job_log (job, at_ms, line) VALUES (" + number + ", 1, 'a line')").c_str());
        if (version >= 3 && seq > 2)
            store.execute(("UPDATE jobs SET reference_job = " + std::to_string(1 + seq % 2) +
                           R"(, comparison = 1, curve = '[{"passes":1}]', error_now = '{"metric":"rmse","value":1}')" +
                           " WHERE seq = " + number)
                              .c_str());
    }
    store.execute("INSERT INTO keys VALUES ('key', 'hash', 1, 2)");
    store.execute("INSERT INTO scenes VALUES (5, '0123', 'a scene', 'a.glb', '{}', 1)");
    store.execute(
        "INSERT INTO images (id, media_type, file, width, height, channels, bytes, created_ms) VALUES "
        "('4567', 'image/x-exr', '4567.exr', 2, 1, 3, 100, 1)");
    if (version >= 3) {
        store.execute("UPDATE jobs SET role = 1, content = 'what it shows' WHERE seq <= 2");
        store.execute("INSERT INTO comparisons VALUES (1, 's', '{}', 1, 0)");
        for (int place = 0; place < 20; ++place)
            store.execute(("INSERT INTO comparison_jobs (comparison, place, job, label, parameters, seed) VALUES (1, " +
                           std::to_string(place) + ", " + std::to_string(3 + place) + ", 'a', '{}', 1)")
                              .c_str());
    }
    if (version >= 8) store.execute("INSERT INTO unnamed_files VALUES ('films/J50-1.film')");
    transaction.commit();
}

using Columns = std::map<std::string, std::vector<std::string>>;  // by table

Columns columns_of(Database& store) {
    Columns columns;
    Statement read =
        store.prepare("SELECT t.name, c.name FROM sqlite_schema t, pragma_table_info(t.name) c WHERE t.type = 'table'");
    while (read.step()) columns[read.text(0)].push_back(read.text(1));
    return columns;
}

/// All that is in those columns, row by row.
std::string content_of(Database& store, const Columns& columns) {
    std::string content;
    for (const auto& [table, names] : columns) {
        if (table == "labels") continue;  // step 5 drops it: what is in it, is in requests too
        std::string row;
        for (const std::string& name : names) row += (row.empty() ? "" : " || ',' || ") + ("quote(" + name + ")");
        Statement read = store.prepare("SELECT " + row + " FROM " + table + " ORDER BY 1");
        content += table + "\n";
        while (read.step()) content += read.text(0) + "\n";
    }
    return content;
}

struct Content {
    Columns columns;
    std::string text;
};

Content content_of(const fs::path& file) {
    Database store(file, kSchemaVersion);
    Content content{columns_of(store), {}};
    if (store.found_version() < 8) content.columns.erase("meta");  // step 8 adds to it
    content.text = content_of(store, content.columns);
    return content;
}

// --- Being killed

/// Calls of the system that change a file, of which the last one that is allowed is done by half.
struct Killer {
    static inline int left = 0;
    static inline bool halves = false;

    static ssize_t write(int file, const void* data, size_t bytes, off_t at) {
        if (--left > 0) return ::pwrite(file, data, bytes, at);
        if (halves) (void)!::pwrite(file, data, bytes / 2, at);
        ::raise(SIGKILL);
        return -1;
    }
    static int cut(int file, off_t bytes) {
        if (--left > 0) return ::ftruncate(file, bytes);
        ::raise(SIGKILL);
        return -1;
    }
    static int remove(const char* path) {
        if (--left > 0) return ::unlink(path);
        ::raise(SIGKILL);
        return -1;
    }
};

/// Opens the store in a process of its own, which is killed at its `calls`-th change of a file; whether it was.
bool opened_and_killed(const fs::path& file, int calls) {
    const pid_t child = fork();
    if (child == 0) {
        Killer::left = calls;
        Killer::halves = calls % 2 == 0;
        sqlite3_vfs* system = sqlite3_vfs_find(nullptr);
        const std::pair<const char*, sqlite3_syscall_ptr> own[] = {
            {"pwrite", reinterpret_cast<sqlite3_syscall_ptr>(&Killer::write)},
            {"pwrite64", reinterpret_cast<sqlite3_syscall_ptr>(&Killer::write)},
            {"ftruncate", reinterpret_cast<sqlite3_syscall_ptr>(&Killer::cut)},
            {"unlink", reinterpret_cast<sqlite3_syscall_ptr>(&Killer::remove)}};
        for (const auto& [name, call] : own) {
            const int code = system->xSetSystemCall(system, name, call);
            if (code != SQLITE_OK && code != SQLITE_NOTFOUND) _exit(2);
        }
        try {
            const Store store(file);
        } catch (...) {
            _exit(3);
        }
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) {
        EXPECT_EQ(WTERMSIG(status), SIGKILL);
        return true;
    }
    EXPECT_EQ(WEXITSTATUS(status), 0) << "the store did not open after " << calls << " calls";
    return false;
}

void expect_up_to_date(const fs::path& file, const Content& before, const std::string& when) {
    {
        Store store(file);
        ASSERT_EQ(store.database().integrity(), "ok") << when;
        ASSERT_EQ(content_of(store.database(), before.columns), before.text) << when;
        const std::optional<JobRow> job = store.job(3);
        ASSERT_TRUE(job) << when;
        EXPECT_EQ(job->film, "J3-1.film");
        EXPECT_EQ(store.films().size(), size_t{kOldJobs});
        JobQuery labelled;
        labelled.label_key = "study";
        EXPECT_EQ(store.count_jobs(labelled), kOldJobs) << when;
        EXPECT_EQ(store.id().size(), 32u);
        auto transaction = store.transaction();  // and it is written as ever
        JobRow row = *job;
        row.seconds = 2;
        store.update_job(row);
        transaction.commit();
    }
    Store again(file);
    EXPECT_EQ(again.database().found_version(), kSchemaVersion) << when;
    EXPECT_EQ(again.job(3)->seconds, 2) << when;
}

void copy_store(const fs::path& from, const fs::path& to) {
    for (const char* suffix : {"", "-wal", "-journal", "-shm"}) {
        fs::remove(to.string() + suffix);
        if (fs::exists(from.string() + suffix)) fs::copy_file(from.string() + suffix, to.string() + suffix);
    }
}

class StoreMigration : public testing::TestWithParam<int> {};

TEST_P(StoreMigration, LosesNothingWheneverItIsKilled) {
    const TemporaryFolder folder;
    const fs::path old = folder.path / "old", store = folder.path / "store", chain = folder.path / "chain";
    make_old_store(old, GetParam());
    const Content before = content_of(old);
    ASSERT_NE(before.text.find("J60-1.film"), std::string::npos);
    copy_store(old, chain);
    const int step = GetParam() == kOldVersion ? 1 : 3;  // by threes where there are a hundred; odd: halves in turn
    int moments = 0;
    bool killed = true;
    for (int call = 1; killed; call += step, ++moments) {
        copy_store(old, store);
        killed = opened_and_killed(store, call);
        expect_up_to_date(store, before, "killed at call " + std::to_string(call));
        if (HasFailure()) return;
        opened_and_killed(chain, call);  // the one that is killed again and again
    }
    EXPECT_GT(moments, 10) << "too few to be a test: are the calls still made?";
    expect_up_to_date(chain, before, "killed at each call in turn");
    RecordProperty("moments", moments);
}

INSTANTIATE_TEST_SUITE_P(Versions, StoreMigration, testing::Values(kOldVersion, 1),
                         [](const auto& version) { return "Version" + std::to_string(version.param); });

TEST(StoreOfBefore, JobsHaveOneReferenceAndAComparisonItsJobs) {
    const TemporaryFolder folder;
    make_old_store(folder.path / "s", kOldVersion);
    Store store(folder.path / "s");
    EXPECT_EQ(store.job(3)->reference_jobs, std::vector<int64_t>{2});
    EXPECT_EQ(store.job(3)->error_now, R"({"metric":"rmse","value":1})");
    EXPECT_EQ(store.comparison_jobs(1).size(), 20u);
    EXPECT_EQ(store.queued_jobs().size(), size_t{kOldJobs / 4});
}

}  // namespace
}  // namespace photond::store_migration_test
