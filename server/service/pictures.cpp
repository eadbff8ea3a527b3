#include "server/service/pictures.h"

#include <algorithm>
#include <utility>

#include "server/asks_again.h"
#include "server/processor_time.h"
#include "server/try_later.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

constexpr double kMostSeconds = 1;               // of rendering, by the helper that others wait for
constexpr std::chrono::milliseconds kLook{250};  // whether the jobs are over

TryLater not_now(const char* why) {
    return {std::string("a job renders, and ") + why, static_cast<int>(Pictures::kPatience.count())};
}

/// Of a picture in the line.
TryLater under_way(int after_seconds) {
    return {"a job renders, and this picture is drawn beside it", after_seconds, true};
}

}  // namespace

Pictures::Pictures(ServiceCore& core, ArtefactFiles& artefact_files)
    : core_(core), artefact_files_(artefact_files), line_(std::max(1u, std::thread::hardware_concurrency())) {}

Pictures::~Pictures() {
    begin_stop(SteadyClock::now());
    join();
}

void Pictures::start(ProcessOptions process, std::function<void(const ProcessExit&)> exited) {
    process.threads = 1;
    process.priority.background = true;
    background_ = std::make_unique<Helper>(
        std::move(process), core_.options.limits.helper_timeout_seconds, [] {}, std::move(exited));
    thread_ = std::thread([this] { run(); });
}

void Pictures::begin_stop(SteadyClock::time_point deadline) {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    if (background_) background_->begin_stop(deadline);
}

void Pictures::join() {
    if (thread_.joinable()) thread_.join();
    if (background_) background_->join();
}

size_t Pictures::waiting() const {
    const std::lock_guard lock(mutex_);
    return line_.waiting();
}

bool Pictures::drawn_at_once(const std::function<void(const Draughtsman& by)>& draw) {
    if (core_.jobs_on_host_cores > 0) return false;
    const std::lock_guard turn(at_once_);
    if (core_.jobs_on_host_cores > 0) return false;
    draw({*core_.helper, kMostSeconds});
    return true;
}

Artefact Pictures::picture(const std::string& name, const std::string& key, const std::string& media_type,
                           const Draw& draw) {
    if (auto kept = artefact_files_.kept(key, media_type)) return *std::move(kept);
    const auto drawn_by = [this, key, media_type, draw](const Draughtsman& by) {
        return artefact_files_.artefact(key, media_type, [&](const fs::path& path) { return draw(by, path); });
    };
    Artefact drawn;
    if (drawn_at_once([&](const Draughtsman& by) { drawn = drawn_by(by); })) return drawn;
    return drawn_beside(name, [this, drawn_by] { return drawn_by({*background_, std::nullopt}); });
}

Artefact Pictures::drawn_beside(const std::string& name, const std::string& key, const std::string& media_type,
                                const Draw& draw) {
    if (auto kept = artefact_files_.kept(key, media_type)) return *std::move(kept);
    return drawn_beside(name, [this, key, media_type, draw] {
        return artefact_files_.artefact(key, media_type, [&](const fs::path& path) {
            return draw({*background_, std::nullopt}, path);
        });
    });
}

Artefact Pictures::drawn_beside(const std::string& name, const std::function<Artefact()>& draw) {
    std::unique_lock lock(mutex_);
    const auto picture = line_.want(name, draw, PictureLine::Clock::now());
    if (!picture) throw not_now("too many pictures wait to be drawn beside it");
    changed_.notify_all();
    if (!picture->over) {
        if (client_asks_again()) throw under_way(1);
        if (callers_ >= kMostCallers) throw not_now("others wait for pictures to be drawn beside it");
        ++callers_;
        changed_.wait_for(lock, kPatience, [&] { return picture->over || stopping_; });
        --callers_;
    }
    if (stopping_) throw Error(ErrorCode::Unavailable, "the daemon is stopping");
    if (!picture->over) throw under_way(static_cast<int>(kPatience.count()));
    line_.remove(*picture);
    if (picture->failure) std::rethrow_exception(picture->failure);
    return picture->drawn;
}

void Pictures::run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        const auto now = PictureLine::Clock::now();
        const std::shared_ptr<WantedPicture> picture = line_.next(now, core_.jobs_on_host_cores > 0);
        if (!picture) {
            if (line_.waiting() == 0)
                changed_.wait(lock);
            else
                changed_.wait_for(lock, kLook);
            continue;
        }
        lock.unlock();
        const pid_t process = background_->pid();
        const double before = processor_seconds_of(process).value_or(0);
        Artefact drawn;
        std::exception_ptr failure;
        try {
            drawn = picture->draw();
        } catch (...) {
            failure = std::current_exception();
        }
        const double after = processor_seconds_of(process).value_or(before);
        lock.lock();
        picture->over = true;
        picture->drawn = std::move(drawn);
        picture->failure = failure;
        picture->draw = nullptr;  // what it holds is let go
        line_.note(now, after - before);
        changed_.notify_all();
    }
}

}  // namespace photond
