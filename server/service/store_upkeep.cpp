#include "server/service/store_upkeep.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <chrono>
#include <exception>
#include <utility>

namespace photond {

using nlohmann::json;

namespace {

constexpr std::chrono::seconds kBetweenTries{1};  // between two tries
constexpr int kNice = 10;                         // who serves and renders goes first

}  // namespace

StoreUpkeep::~StoreUpkeep() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    woken_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void StoreUpkeep::start() {
    thread_ = std::thread([this] { run(); });
}

void StoreUpkeep::run() {
    setpriority(PRIO_PROCESS, 0, kNice);  // of this thread alone
    for (bool checked = false; !stopping_;) {
        try {
            const bool recovered = recovery_.is_finished() || recovery_.finish();
            checked = checked || check();
            if (checked && recovered) return;
        } catch (const std::exception& error) {
            spdlog::error("the store's upkeep: {}", error.what());
        }
        std::unique_lock lock(mutex_);
        woken_.wait_for(lock, kBetweenTries, [this] { return stopping_.load(); });
    }
}

bool StoreUpkeep::check() {
    try {
        const std::lock_guard lock(core_.mutex);
        core_.store.database().begin_whole_check();
        check_state_ = "running";
    } catch (const Error& error) {
        note("waiting", error.what());
        return false;
    }
    const auto begun = SteadyClock::now();
    std::string found;
    try {
        found = Database::check_whole(core_.files.store, stopping_);
    } catch (const Error& error) {
        note("failed", error.what());
    }
    {
        const std::lock_guard lock(core_.mutex);
        core_.store.database().end_whole_check();
    }
    if (found.empty()) return true;
    const double seconds = std::chrono::duration<double>(SteadyClock::now() - begun).count();
    if (found == "ok") {
        spdlog::info("the store is whole: checked in {:.2f} s", seconds);
        note("ok", "");
    } else {
        spdlog::critical("the store is damaged: {}", found);
        note("damaged", found);
    }
    return true;
}

void StoreUpkeep::note(const char* state, std::string detail) {
    const std::lock_guard lock(core_.mutex);
    check_state_ = state;
    check_detail_ = std::move(detail);
}

json StoreUpkeep::status() const {
    const Quarantine& quarantine = recovery_.quarantine();
    return {{"id", core_.store.id()},
            {"bytes", bytes_below(core_.files.store)},
            {"recovered", recovery_.is_finished()},
            {"check", {{"state", check_state_}, {"detail", check_detail_.empty() ? json() : json(check_detail_)}}},
            {"quarantine", {{"files", quarantine.files()}, {"bytes", quarantine.bytes()}}}};
}

}  // namespace photond
