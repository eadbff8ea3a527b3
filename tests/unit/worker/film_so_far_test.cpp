// The film so far, asked for while a pass is under way: it is there before the pass is, the pass does not change it
// meanwhile, and the clock does not run while they wait for one another.

#include "server/worker/film_so_far.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <vector>

#include "renderer/scene/scene.h"
#include "tests/support/counting_method.h"

namespace photond::film_so_far_test {
namespace {

namespace fs = std::filesystem;
using test::CountingMethod;

class FilmSoFarTest : public testing::Test {
protected:
    ~FilmSoFarTest() override { fs::remove(path_); }

    PassLoop::Result run(uint32_t passes) {
        const Size2 size{4, 2};
        const RenderContext context{scene_, &intersector_, {Camera(), size, PixelFilter::Box, LayerSet()}, 1, budget_};
        FilmSoFar so_far(requests_, {"scene", "settings", "device"}, "J1",
                         {[this](ProgressMessage progress) { on_progress(progress); },
                          [this](const fs::path& path, uint32_t done) { on_saved(path, done); }},
                         stats_, meters_);
        PassLoop loop{method, context, {.seconds = {}, .passes = passes}, cancel_};
        loop.reader = &so_far;
        loop.after_pass = [&](const Film& film, double seconds) {
            so_far.tell({.job = "J1",
                         .attempt = 1,
                         .passes_done = film.passes(),
                         .progress = 0,
                         .seconds = seconds,
                         .error_now = {}});
            return false;
        };
        return loop.run(stats_);
    }
    /// In the pass of that index, before it is done.
    void in_pass(uint32_t pass, std::function<void()> act) {
        method.in_pass = [this, pass, act = std::move(act)](Stats&, const CancelToken&) {
            if (method.passes_run == pass + 1) act();
        };
    }

    const fs::path path_ = fs::temp_directory_path() / ("photond_film_so_far_" + std::to_string(getpid()) + ".film");
    FilmRequests requests_;
    CountingMethod method;
    std::function<void(const ProgressMessage&)> on_progress = [](const ProgressMessage&) {};
    std::function<void(const fs::path&, uint32_t)> on_saved = [](const fs::path&, uint32_t) {};
    Stats stats_;

private:
    Scene scene_;
    test::NoIntersector intersector_;
    MemoryBudget budget_;
    CancelToken cancel_;
    RenderMeters meters_;
};

TEST_F(FilmSoFarTest, IsThereBeforeThePassThatIsUnderWay) {
    std::promise<uint32_t> saved;
    on_saved = [&](const fs::path&, uint32_t passes) { saved.set_value(passes); };
    in_pass(2, [&] {
        requests_.ask(path_);
        EXPECT_EQ(saved.get_future().get(), 2u);
        const SavedFilm film = FilmFile::load(path_);
        EXPECT_EQ(film.film.passes(), 2u);
        EXPECT_EQ(film.film.resolve_beauty()[0], 1.5f);  // of 1 and 2
        EXPECT_EQ(film.identity.scene, "scene");
    });
    EXPECT_EQ(run(4).film.resolve_beauty()[0], 2.5f);
}

TEST_F(FilmSoFarTest, IsTheOneAfterThePassWhereThatIsSoonDone) {
    std::vector<uint32_t> saved;
    on_saved = [&](const fs::path&, uint32_t passes) { saved.push_back(passes); };
    requests_.ask(path_);  // before there is one
    run(3);
    EXPECT_EQ(saved, std::vector<uint32_t>{1});
    EXPECT_EQ(FilmFile::load(path_).film.passes(), 1u);
}

TEST_F(FilmSoFarTest, DoesNotChangeWhileItIsReadAndTheClockWaits) {
    std::promise<void> reading;
    std::atomic<bool> settled = false;
    double waited = 0;
    on_saved = [&](const fs::path&, uint32_t) {
        reading.set_value();
        const double start = wall_now_seconds();
        while (!settled) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the loop has found it being read
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        waited = wall_now_seconds() - start;
    };
    method.on_settle = [&] { settled = true; };
    in_pass(1, [&] {
        requests_.ask(path_);
        reading.get_future().wait();
    });
    const double start = wall_now_seconds();
    const PassLoop::Result result = run(3);
    EXPECT_EQ(method.said, "e1re2srr");
    EXPECT_LE(result.render_seconds + 0.1, wall_now_seconds() - start);
    EXPECT_GE(stats_.stage("film_saving").wall_seconds, 0.1);
    EXPECT_GE(waited, 0.1);
    EXPECT_EQ(FilmFile::load(path_).film.passes(), 1u);
    EXPECT_EQ(result.film.resolve_beauty()[0], 2.0f);
}

TEST_F(FilmSoFarTest, ProgressIsToldDuringALongPassToo) {
    std::promise<void> told;
    std::vector<uint32_t> heard;
    on_progress = [&](const ProgressMessage& progress) {
        heard.push_back(progress.passes_done);
        if (progress.passes_done == 3) told.set_value();
    };
    in_pass(3, [&] { told.get_future().wait(); });
    run(4);
    ASSERT_GE(heard.size(), 2u);
    EXPECT_EQ(heard.front(), 1u);  // at once
    EXPECT_LE(heard.size(), 4u);
}

TEST_F(FilmSoFarTest, ADiskThatCannotTakeItIsNotTheJobsConcern) {
    on_saved = [&](const fs::path&, uint32_t) { ADD_FAILURE() << "there is nothing to be read"; };
    requests_.ask(fs::temp_directory_path() / "photond_no_such_folder" / "so_far.film");
    EXPECT_EQ(run(3).film.passes(), 3u);
}

TEST_F(FilmSoFarTest, IsLetGoOfWhenThePassFails) {
    std::promise<void> reading;
    on_saved = [&](const fs::path&, uint32_t) {
        reading.set_value();
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    };
    in_pass(1, [&] {
        requests_.ask(path_);
        reading.get_future().wait();
        throw std::runtime_error("this pass cannot be rendered");
    });
    EXPECT_THROW(run(3), std::runtime_error);
    EXPECT_EQ(FilmFile::load(path_).film.passes(), 1u);
}

}  // namespace
}  // namespace photond::film_so_far_test
