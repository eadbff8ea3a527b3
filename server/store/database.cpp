#include "server/store/database.h"

#include <sqlite3.h>

#include <cassert>
#include <cerrno>

#include "protocol/error.h"

namespace photond {

namespace {

[[noreturn]] void fail(sqlite3* database, const std::string& doing) {
    const int code = database ? sqlite3_extended_errcode(database) : SQLITE_NOMEM;
    const std::string text = doing + ": " + (database ? sqlite3_errmsg(database) : "out of memory") + " (SQLite " +
                             std::to_string(code) + ")";
    // A full disk shows as FULL, or as a failed write whose errno is ENOSPC.
    if ((code & 0xff) == SQLITE_FULL ||
        ((code & 0xff) == SQLITE_IOERR && database && sqlite3_system_errno(database) == ENOSPC))
        throw Error(ErrorCode::NoSpace, text);
    throw Error(ErrorCode::Internal, text);
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

Database::~Database() {
    for (auto& [sql, statement] : statements_) sqlite3_finalize(statement);
    sqlite3_close(database_);
}

void Database::migrate(const std::filesystem::path& file, const char* const* migrations, int count) {
    int version = 0;
    {
        Statement read = prepare("PRAGMA user_version");
        if (read.step()) version = static_cast<int>(read.integer(0));
    }
    if (version > count)
        throw Error(ErrorCode::Internal, "the store has schema version " + std::to_string(version) +
                                             ", this program knows up to " + std::to_string(count));
    // Reading every page of a large store would cost seconds; there a damaged page shows when it is read.
    constexpr uintmax_t kCheckedBytes = 64u << 20;
    if (std::filesystem::file_size(file) <= kCheckedBytes) {
        Statement check = prepare("PRAGMA quick_check(1)");
        if (!check.step() || check.text(0) != "ok")
            throw Error(ErrorCode::Internal, "the store is damaged: " + check.text(0));
    }
    for (; version < count; ++version) {
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
