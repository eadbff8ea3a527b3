#pragma once
// A thin owner of one SQLite connection: WAL, synchronous FULL, exclusive lock; statements are prepared once.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_backup;
struct sqlite3_stmt;

namespace photond {

/// A prepared statement in use; reset when it goes out of scope. Parameters and columns are numbered as in SQLite
/// (parameters from 1, columns from 0).
class Statement {
public:
    explicit Statement(sqlite3* database, sqlite3_stmt* statement) : database_(database), statement_(statement) {}
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(int index, int64_t value);
    Statement& bind(int index, double value);
    Statement& bind(int index, std::string_view value);
    Statement& bind(int index, std::nullptr_t);
    template <class T>
    Statement& bind(int index, const std::optional<T>& value) {
        return value ? bind(index, *value) : bind(index, nullptr);
    }

    /// True while there is a row to read.
    bool step();
    void run() {
        while (step()) {
        }
    }

    bool is_null(int column) const;
    int64_t integer(int column) const;
    std::optional<int64_t> optional_integer(int column) const;  // nothing for NULL
    double real(int column) const;
    std::string text(int column) const;

private:
    sqlite3* database_;
    sqlite3_stmt* statement_;
};

/// Not thread-safe: its owner serialises. Failures are photond::Error: NoSpace when the disk is full, else Internal.
class Database {
public:
    /// Opens or makes the file and brings its schema up to date: `migrations[i]` leads from version i to i + 1. Throws
    /// when the file is of a newer version, damaged, or open in another process.
    Database(const std::filesystem::path& file, const char* const* migrations, int count);
    /// To be read: nothing is written, and what the last owner left unfinished stays as it is. The caller holds the
    /// data folder's lock, for SQLite's own locks are not taken. Of any version up to `known`.
    Database(const std::filesystem::path& file, int known);
    ~Database();
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    /// Prepared once and kept: the text must come from a small fixed set, with values bound, never pasted in.
    Statement prepare(std::string_view sql);
    void execute(const char* sql);
    int64_t last_insert_id() const;
    int64_t changes() const;
    /// The schema's version as it was found; 0: the file was made now, or was empty.
    int found_version() const { return found_version_; }

    /// SQLite's integrity_check: "ok" or what is wrong, a line each.
    std::string integrity();
    /// The same of all that is in the file, from another thread and while this connection writes on: between begin and
    /// end it writes to its log alone. begin throws where the log cannot be emptied first (a full disk).
    void begin_whole_check();
    /// Needs no connection. Empty when `stop` has become true meanwhile.
    static std::string check_whole(const std::filesystem::path& file, const std::atomic<bool>& stop);
    void end_whole_check();
    /// Copies all of it, some pages at a time, into a new file; see Copy.
    class Copy;

    /// Rolled back unless commit() is called; commit() returns when the data is on the disk.
    class Transaction {
    public:
        explicit Transaction(Database& database) : database_(database) { database_.execute("BEGIN IMMEDIATE"); }
        ~Transaction();
        Transaction(const Transaction&) = delete;
        Transaction& operator=(const Transaction&) = delete;
        void commit();

    private:
        Database& database_;
        bool open_ = true;
    };

private:
    void migrate(const std::filesystem::path& file, const char* const* migrations, int count);
    void read_version(int known);

    sqlite3* database_ = nullptr;
    int found_version_ = 0;
    std::map<std::string, sqlite3_stmt*, std::less<>> statements_;
};

/// A copy under way. What this connection writes meanwhile reaches the copy too, so that it is of one moment: the last
/// step's. All under its owner's lock, which is free between the steps.
class Database::Copy {
public:
    Copy(Database& from, const std::filesystem::path& to);
    ~Copy();
    Copy(const Copy&) = delete;
    Copy& operator=(const Copy&) = delete;

    /// Copies so many pages more (-1: all); how many are left then.
    int step(int pages);

private:
    sqlite3* to_ = nullptr;
    sqlite3_backup* backup_ = nullptr;
};

}  // namespace photond
