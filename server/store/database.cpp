#include "server/store/database.h"

#include <sqlite3.h>

#include <cassert>
#include <cerrno>
#include <cstdio>
#include <memory>

#include "protocol/error.h"

namespace photond {

namespace {

/// A full disk shows as FULL, or as a failed write whose errno is ENOSPC.
bool is_no_space(sqlite3* database, int code) {
    return (code & 0xff) == SQLITE_FULL ||
           ((code & 0xff) == SQLITE_IOERR && database && sqlite3_system_errno(database) == ENOSPC);
}

[[noreturn]] void fail(sqlite3* database, const std::string& doing) {
    const int code = database ? sqlite3_extended_errcode(database) : SQLITE_NOMEM;
    const std::string text = doing + ": " + (database ? sqlite3_errmsg(database) : "out of memory") + " (SQLite " +
                             std::to_string(code) + ")";
    if (is_no_space(database, code)) throw Error(ErrorCode::NoSpace, text);
    throw Error(ErrorCode::Internal, text);
}

/// For reading, as it lies on the disk: neither locks nor the log are looked at, and no other connection is disturbed.
int open_immutable(const std::filesystem::path& file, sqlite3** database) {
    std::string uri = "file:";
    for (const char c : file.string()) {
        char escaped[4];
        std::snprintf(escaped, sizeof escaped, "%%%02x", static_cast<unsigned char>(c));
        uri += c == '/' ? "/" : escaped;
    }
    return sqlite3_open_v2((uri + "?immutable=1").c_str(), database,
                           SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
}

}  // namespace

Statement::~Statement() {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
}

Statement& Statement::bind(int index, int64_t value) {
    if (sqlite3_bind_int64(statement_, index, value) != SQLITE_OK) fail(database_, "binding a number");
    return *this;
}

Statement& Statement::bind(int index, double value) {
    if (sqlite3_bind_double(statement_, index, value) != SQLITE_OK) fail(database_, "binding a number");
    return *this;
}

Statement& Statement::bind(int index, std::string_view value) {
    if (sqlite3_bind_text64(statement_, index, value.data() ? value.data() : "", value.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8) != SQLITE_OK)
        fail(database_, "binding a text");
    return *this;
}

Statement& Statement::bind(int index, std::nullptr_t) {
    if (sqlite3_bind_null(statement_, index) != SQLITE_OK) fail(database_, "binding null");
    return *this;
}

bool Statement::step() {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) fail(database_, "the store");
    return false;
}

bool Statement::is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_, column); }
std::optional<int64_t> Statement::optional_integer(int column) const {
    return is_null(column) ? std::nullopt : std::optional(integer(column));
}
double Statement::real(int column) const { return sqlite3_column_double(statement_, column); }

std::string Statement::text(int column) const {
    const unsigned char* bytes = sqlite3_column_text(statement_, column);
    if (!bytes) return {};
    return {reinterpret_cast<const char*>(bytes), static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
}

Database::Database(const std::filesystem::path& file, const char* const* migrations, int count) {
    if (sqlite3_open_v2(file.c_str(), &database_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX,
                        nullptr) != SQLITE_OK) {
        const std::string text = database_ ? sqlite3_errmsg(database_) : "out of memory";
        sqlite3_close(database_);
        throw Error(ErrorCode::Internal, "cannot open the store " + file.string() + ": " + text);
    }
    try {
        sqlite3_extended_result_codes(database_, 1);
        sqlite3_busy_timeout(database_, 2000);
        // One connection only: SQLite 3.40.1 is in the range of the WAL-reset bug, which needs two
        // (reliability.md, "Measured on Debian 12's packages").
        execute("PRAGMA locking_mode = EXCLUSIVE");
        execute("PRAGMA journal_mode = WAL");
        execute("PRAGMA synchronous = FULL");
        execute("PRAGMA foreign_keys = ON");
        execute("PRAGMA cache_size = -32768");
        migrate(file, migrations, count);
    } catch (...) {
        for (auto& [sql, statement] : statements_) sqlite3_finalize(statement);
        sqlite3_close(database_);
        throw;
    }
}

Database::Database(const std::filesystem::path& file, int known) {
    // unix-none takes no locks, which a file opened for reading alone could not take; the log is then read into memory.
    // Where there is no log one would be made, unless the file is said not to change.
    std::error_code none;
    const bool has_log = std::filesystem::exists(file.string() + "-wal", none);
    const int code =
        has_log ? sqlite3_open_v2(file.c_str(), &database_, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, "unix-none")
                : open_immutable(file, &database_);
    if (code != SQLITE_OK) {
        const std::string text = database_ ? sqlite3_errmsg(database_) : "out of memory";
        sqlite3_close(database_);
        throw Error(ErrorCode::Internal, "cannot open the store " + file.string() + ": " + text);
    }
    try {
        sqlite3_extended_result_codes(database_, 1);
        sqlite3_db_config(database_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
        execute("PRAGMA locking_mode = EXCLUSIVE");
        read_version(known);
    } catch (...) {
        sqlite3_close(database_);
        throw;
    }
}

Database::~Database() {
    for (auto& [sql, statement] : statements_) sqlite3_finalize(statement);
    sqlite3_close(database_);
}

void Database::read_version(int known) {
    Statement read = prepare("PRAGMA user_version");
    if (read.step()) found_version_ = static_cast<int>(read.integer(0));
    if (found_version_ > known)
        throw Error(ErrorCode::Internal, "the store has schema version " + std::to_string(found_version_) +
                                             ", this program knows up to " + std::to_string(known));
}

void Database::migrate(const std::filesystem::path& file, const char* const* migrations, int count) {
    read_version(count);
    // Reading every page of a large store would cost seconds; that is done beside the serving (check_whole).
    constexpr uintmax_t kCheckedBytes = 64u << 20;
    if (std::filesystem::file_size(file) <= kCheckedBytes) {
        Statement check = prepare("PRAGMA quick_check(1)");
        if (!check.step() || check.text(0) != "ok")
            throw Error(ErrorCode::Internal, "the store is damaged: " + check.text(0));
    }
    for (int version = found_version_; version < count; ++version) {
        Transaction transaction(*this);
        execute(migrations[version]);
        execute(("PRAGMA user_version = " + std::to_string(version + 1)).c_str());
        transaction.commit();
    }
}

Statement Database::prepare(std::string_view sql) {
    auto found = statements_.find(sql);
    if (found == statements_.end()) {
        sqlite3_stmt* statement = nullptr;
        if (sqlite3_prepare_v3(database_, sql.data(), static_cast<int>(sql.size()), SQLITE_PREPARE_PERSISTENT,
                               &statement, nullptr) != SQLITE_OK)
            fail(database_, "preparing " + std::string(sql));
        found = statements_.emplace(sql, statement).first;
    }
    assert(!sqlite3_stmt_busy(found->second) && "a statement has one reader at a time");
    return Statement(database_, found->second);
}

void Database::execute(const char* sql) {
    if (sqlite3_exec(database_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(database_, sql);
}

int64_t Database::last_insert_id() const { return sqlite3_last_insert_rowid(database_); }
int64_t Database::changes() const { return sqlite3_changes64(database_); }

std::string Database::integrity() {
    Statement check = prepare("PRAGMA integrity_check");
    std::string lines;
    while (check.step()) lines += (lines.empty() ? "" : "\n") + check.text(0);
    return lines.empty() ? "no answer" : lines;
}

void Database::begin_whole_check() {
    {
        Statement checkpoint = prepare("PRAGMA wal_checkpoint(TRUNCATE)");
        if (!checkpoint.step() || checkpoint.integer(0) != 0)
            throw Error(ErrorCode::Internal, "the store's log cannot be emptied now");
    }
    execute("PRAGMA wal_autocheckpoint = 0");
}

void Database::end_whole_check() { execute("PRAGMA wal_autocheckpoint = 1000"); }

std::string Database::check_whole(const std::filesystem::path& file, const std::atomic<bool>& stop) {
    sqlite3* opened = nullptr;
    const int code = open_immutable(file, &opened);
    const std::unique_ptr<sqlite3, int (*)(sqlite3*)> database(opened, &sqlite3_close);
    if (code != SQLITE_OK) fail(opened, "opening the store to check it");
    constexpr int kInstructionsBetweenLooks = 10'000;
    sqlite3_progress_handler(
        opened, kInstructionsBetweenLooks,
        [](void* asked) { return static_cast<const std::atomic<bool>*>(asked)->load() ? 1 : 0; },
        const_cast<std::atomic<bool>*>(&stop));
    std::string lines;
    const auto add_line = [](void* to, int columns, char** values, char**) {
        auto& text = *static_cast<std::string*>(to);
        if (columns > 0 && values[0]) text += (text.empty() ? "" : "\n") + std::string(values[0]);
        return 0;
    };
    const int result = sqlite3_exec(opened, "PRAGMA integrity_check", add_line, &lines, nullptr);
    if (stop) return "";
    if ((result & 0xff) == SQLITE_CORRUPT || (result & 0xff) == SQLITE_NOTADB)  // too damaged to be checked to the end
        return lines + (lines.empty() ? "" : "\n") + sqlite3_errmsg(opened);
    if (result != SQLITE_OK) fail(opened, "checking the store");
    return lines;
}

Database::Copy::Copy(Database& from, const std::filesystem::path& to) {
    if (sqlite3_open_v2(to.c_str(), &to_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr) ==
            SQLITE_OK &&
        // A copy that a crash cuts short is none: nobody need wait, under the lock, until it is on the disk.
        sqlite3_exec(to_, "PRAGMA synchronous = OFF; PRAGMA journal_mode = OFF", nullptr, nullptr, nullptr) ==
            SQLITE_OK)
        backup_ = sqlite3_backup_init(to_, "main", from.database_, "main");
    if (backup_) return;
    const std::string text = to_ ? sqlite3_errmsg(to_) : "out of memory";
    sqlite3_close(to_);
    throw Error(ErrorCode::Internal, "the store cannot be copied to " + to.string() + ": " + text);
}

Database::Copy::~Copy() {
    sqlite3_backup_finish(backup_);
    sqlite3_close(to_);
}

int Database::Copy::step(int pages) {
    const int code = sqlite3_backup_step(backup_, pages);
    if (code == SQLITE_OK || code == SQLITE_DONE) return sqlite3_backup_remaining(backup_);
    if (is_no_space(to_, code)) throw Error(ErrorCode::NoSpace, "the disk is full: the store cannot be copied");
    throw Error(ErrorCode::Internal, std::string("copying the store: ") + sqlite3_errstr(code));
}

Database::Transaction::~Transaction() {
    // Some failures (a full disk) have rolled back already; a second rollback is then an error without meaning.
    if (open_ && !sqlite3_get_autocommit(database_.database_))
        sqlite3_exec(database_.database_, "ROLLBACK", nullptr, nullptr, nullptr);
}

void Database::Transaction::commit() {
    database_.execute("COMMIT");
    open_ = false;
}

}  // namespace photond
