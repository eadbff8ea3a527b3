// When a film is measured, what is measured then, and when its target counts as met: on films made up here and a clock
// that moves as the tests say.

#include "server/worker/error_follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <span>

#include "protocol/error.h"
#include "renderer/core/rng.h"
#include "server/worker/film_history.h"
#include "server/worker/film_saver.h"
#include "server/worker/off_the_clock.h"
#include "tests/support/temporary_folder.h"

namespace photond::error_follower_test {
namespace {

constexpr Size2 kSize{16, 8};

/// A pass of noise about a ramp from 0.1 to 1.1, direct light alone.
PassImage noisy_pass(uint32_t pass) {
    PassImage image(kSize, LayerSet());
    for (size_t i = 0; i < kSize.pixels(); ++i) {
        RandomStream random(3, RandomDomain::Test, pass, i);
        image.of<Layer::Direct>()[i] =
            Rgb(0.1f + static_cast<float>(i) / static_cast<float>(kSize.pixels())) + Rgb(random.next() - 0.5f);
    }
    return image;
}

std::vector<float> ramp() {
    std::vector<float> values(3 * kSize.pixels());
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = 0.1f + static_cast<float>(i / 3) / static_cast<float>(kSize.pixels());
    return values;
}

class ErrorFollowerTest : public testing::Test {
protected:
    ErrorFollowerTest() { request.width = kSize.width, request.height = kSize.height; }

    void make(std::vector<float> reference) {
        ReferenceImage image;
        image.size = kSize;
        image.layers["beauty"] = std::move(reference);
        make(std::optional(LoadedReference{std::move(image), {}}));
    }
    void make(std::optional<LoadedReference> reference) {
        MeasuringPlan plan = MeasuringPlan::of(request, reference.has_value());
        errors.emplace(kSize, std::move(reference), plan.layers);
        follower.emplace(std::move(plan), *errors, stats, meters, [this] {
            ++readings;
            return time += tick;
        });
    }
    /// Renders passes up to `last` at `pass_seconds` each, or until the target is met.
    bool render_to(uint32_t last, double pass_seconds) {
        while (film.passes() < last) {
            film.add_pass(noisy_pass(film.passes()));
            if (follower->after_pass(film, pass_seconds * film.passes())) return true;
        }
        return false;
    }
    void finish(double seconds) {
        ResolvedFilm resolved(film);
        follower->finish(resolved, seconds);
    }
    std::vector<uint32_t> point_passes() const {
        std::vector<uint32_t> passes;
        for (const CurvePoint& point : follower->curve()) passes.push_back(point.passes);
        return passes;
    }

    JobRequest request;
    Film film{kSize, LayerSet()};
    Stats stats;
    RenderMeters meters;
    double time = 0, tick = 0;
    size_t readings = 0;
    std::optional<FilmErrors> errors;
    std::optional<ErrorFollower> follower;
};

TEST_F(ErrorFollowerTest, PointsAreAtPowersOfTwoAndAtDoubledTimesAndAtTheEnd) {
    make(ramp());
    render_to(40, 0.03);
    // Powers of two, and the first passes that end at or after 0.1 s x 2^k: 0.12, 0.21, 0.42, 0.81 s.
    EXPECT_EQ(point_passes(), (std::vector<uint32_t>{1, 2, 4, 7, 8, 14, 16, 27, 32}));
    finish(1.2);
    EXPECT_EQ(follower->curve().back().passes, 40u);
    EXPECT_EQ(follower->curve().back().seconds, 1.2);
    finish(1.2);
    EXPECT_EQ(follower->curve().size(), 10u);
    EXPECT_EQ(stats.stages.size(), 1u);
    EXPECT_EQ(stats.stages[0].name, kErrorMeasuringStage);
}

TEST_F(ErrorFollowerTest, PointsHoldWhatTheMeterSays) {
    request.metrics = {"flip_ldr", "direct:mae"};
    ReferenceImage reference;
    reference.size = kSize;
    reference.layers["beauty"] = reference.layers["direct"] = ramp();
    make(std::optional(LoadedReference{reference, {}}));
    render_to(4, 0.001);
    finish(0.004);
    const ErrorMeter meter(kSize, ramp());
    const std::vector<float> image = film.resolve_beauty();
    const CurvePoint& last = follower->curve().back();
    for (const Metric metric : {Metric::RelativeMse, Metric::Mse, Metric::Rmse, Metric::Mae, Metric::Smape,
                                Metric::Rmse8bit, Metric::FlipLdr})
        EXPECT_EQ(last.metrics.at(std::string(metric_info(metric).name)), meter.measure(metric, image).front())
            << metric_info(metric).name;
    EXPECT_EQ(last.metrics.at("direct:mae"), meter.measure(Metric::Mae, image).front());
    EXPECT_TRUE(last.metrics.at("estimated_relative_mse").has_value());
    EXPECT_EQ(last.metrics.size(), 11u);  // eight of the beauty, the estimate, two asked for
    EXPECT_FALSE(last.photons.has_value());
    EXPECT_EQ(follower->error_now()->metric, "relative_mse");
    EXPECT_EQ(follower->error_now()->value, *last.metrics.at("relative_mse"));
    EXPECT_FALSE(follower->curve().front().metrics.at("estimated_relative_mse").has_value());  // one pass tells nothing
}

TEST_F(ErrorFollowerTest, WithoutAReferenceTheEstimateIsFollowed) {
    make(std::optional<LoadedReference>());
    EXPECT_FALSE(follower->error_now());
    stats.counts.photons_emitted = 700;
    render_to(8, 0.001);
    const CurvePoint& last = follower->curve().back();
    EXPECT_EQ(last.metrics.size(), 1u);
    EXPECT_EQ(last.photons, 700u);
    EXPECT_EQ(follower->error_now()->metric, "estimated_relative_mse");
    EXPECT_EQ(follower->error_now()->value, *last.metrics.at("estimated_relative_mse"));
}

TEST_F(ErrorFollowerTest, CostlyMetricsWaitUntilThereIsTime) {
    request.metrics = {"flip_ldr"};
    tick = 0.01;  // each measurement
    make(ramp());
    size_t with_flip = 0;
    while (film.passes() < 64) {
        film.add_pass(noisy_pass(film.passes()));
        const size_t points = follower->curve().size();
        follower->after_pass(film, film.passes());
        if (follower->curve().size() == points || !follower->curve().back().metrics.at("flip_ldr")) continue;
        ++with_flip;
        EXPECT_LE(static_cast<double>(readings) / 2 * tick,
                  kMeasuringShare * std::max<double>(film.passes(), kShortestJudgedSeconds))
            << film.passes();
    }
    EXPECT_FALSE(follower->curve().front().metrics.at("flip_ldr").has_value());
    EXPECT_TRUE(follower->curve().front().metrics.at("mae").has_value());
    EXPECT_GE(with_flip, 3u);

    tick = 10;  // from now on there is no time
    while (film.passes() < 200) {
        film.add_pass(noisy_pass(film.passes()));
        follower->after_pass(film, film.passes());
    }
    film.add_pass(noisy_pass(200));
    EXPECT_FALSE(follower->curve().back().metrics.at("flip_ldr").has_value());
    finish(201);
    EXPECT_TRUE(follower->curve().back().metrics.at("flip_ldr").has_value());
}

TEST_F(ErrorFollowerTest, PointsAtOtherThanPowersOfTwoWaitUntilThereIsTime) {
    tick = 0.0015;  // each measurement
    make(ramp());
    for (const double seconds : {2.0, 10.0, 40.0}) {
        film = Film{kSize, LayerSet()};
        readings = 0;
        make(ramp());
        const auto last = static_cast<uint32_t>(seconds / 0.01);
        render_to(last, 0.01);
        finish(seconds);
        EXPECT_LE(static_cast<double>(readings) / 2 * tick, kMeasuringShare * seconds) << seconds;
        for (uint32_t passes = 1; passes <= last; passes *= 2)
            EXPECT_EQ(std::ranges::count(point_passes(), passes), 1) << passes;
    }
    EXPECT_EQ(point_passes().size(),
              1 + 12u + 9);  // the last, powers of two, 0.1 s x 2^k: all of them found their time

    tick = 0.01;  // a point takes as long as a pass
    film = Film{kSize, LayerSet()};
    make(ramp());
    render_to(200, 0.01);
    EXPECT_EQ(point_passes(), (std::vector<uint32_t>{1, 2, 4, 8, 16, 32, 64, 128}));
}

TEST_F(ErrorFollowerTest, ATargetIsMetBySuccessiveLooks) {
    const ErrorMeter meter(kSize, ramp());
    Film truth{kSize, LayerSet()};
    std::vector<double> errors_by_pass;
    for (uint32_t pass = 0; pass < 40; ++pass) {
        truth.add_pass(noisy_pass(pass));
        errors_by_pass.push_back(*meter.pointwise(truth.resolve_beauty())[Metric::RelativeMse]);
    }
    request.stop.target = ErrorTarget{"relative_mse", errors_by_pass[10] * 1.0000001};
    const double target = request.stop.target->value;
    size_t second = 1;
    while (errors_by_pass[second - 1] > target || errors_by_pass[second] > target) ++second;
    make(ramp());
    EXPECT_TRUE(render_to(40, 1));  // measuring takes no time: every pass is looked at
    EXPECT_EQ(film.passes(), second + 1);
    EXPECT_EQ(follower->error_now()->value, errors_by_pass[second]);
    finish(film.passes());
    const auto reached = time_to_error(timed_errors(follower->curve(), "relative_mse"), target);
    ASSERT_TRUE(reached) << "what a job ended by is in its curve";
    EXPECT_GT(*reached, static_cast<double>(second) - 1);
    EXPECT_LE(*reached, static_cast<double>(second));

    film = Film{kSize, LayerSet()};
    tick = 1000;  // only points are looked at
    make(ramp());
    EXPECT_TRUE(render_to(64, 1));
    EXPECT_EQ(follower->curve().back().passes, film.passes());
    const size_t points = follower->curve().size();
    ASSERT_GE(points, 2u);
    for (size_t i = 0; i < points; ++i)
        EXPECT_EQ(*follower->curve()[i].metrics.at("relative_mse") <= target, i + 2 >= points) << i;
}

/// Two references of noise 0.3, of which either alone would hide the target.
TEST_F(ErrorFollowerTest, AgainstTwoFilmsTheUpperEndOfTheIntervalMeetsATarget) {
    const auto noisy = [](uint64_t seed) {
        ReferenceImage image;
        image.size = kSize;
        image.layers["beauty"] = ramp();
        RandomStream random(seed, RandomDomain::Test, 0, 0);
        for (float& value : image.layers["beauty"]) value += random.next() - 0.5f;
        return image;
    };
    const ReferenceImage u = noisy(1), v = noisy(2);
    request.stop.target = ErrorTarget{"mse", 0.02};
    request.metrics = {"rmse", "mae"};
    make(std::optional(LoadedReference{u, v}));
    EXPECT_TRUE(render_to(4000, 1));
    const CrossMeter meter(kSize, u.layers.at("beauty"), v.layers.at("beauty"));
    const CrossError error = meter.measure(film.resolve_beauty()).mse.value();
    EXPECT_LE(error.interval().greatest, 0.02);
    EXPECT_EQ(follower->error_now()->metric, "mse");
    EXPECT_EQ(follower->error_now()->value, error.value);
    EXPECT_DOUBLE_EQ(follower->error_now()->interval->at(0), error.interval().least);
    EXPECT_DOUBLE_EQ(follower->error_now()->interval->at(1), error.interval().greatest);
    finish(film.passes());
    const CurvePoint& last = follower->curve().back();
    EXPECT_EQ(last.metrics.at("mse"), error.value);
    EXPECT_DOUBLE_EQ(last.intervals.at("mse").greatest, error.interval().greatest);
    EXPECT_TRUE(last.intervals.contains("relative_mse") && last.intervals.contains("rmse"));
    EXPECT_EQ(last.metrics.at("rmse").has_value(), error.value >= 0);
    EXPECT_FALSE(last.intervals.contains("mae"));
    // Of what is no mean of squares: against their mean.
    std::vector<float> mean = u.layers.at("beauty");
    for (size_t i = 0; i < mean.size(); ++i) mean[i] = (mean[i] + v.layers.at("beauty")[i]) / 2;
    EXPECT_NEAR(last.metrics.at("mae").value(), ErrorMeter(kSize, mean).measure(Metric::Mae, film.resolve_beauty())[0],
                1e-6);
    // Saved and read again, a point has its intervals.
    const FilmHistory read = FilmHistory::parse(FilmHistory{1, {}, {}, {}, follower->curve(), {}}.text());
    EXPECT_EQ(read.curve.back().intervals, last.intervals);
}

TEST_F(ErrorFollowerTest, TheLookThatFirstMeetsACostlyTargetIsOnTheCurveWithItsValue) {
    request.stop.target = ErrorTarget{"flip_ldr", 0.1};
    tick = 0.001;
    make(ramp());
    EXPECT_TRUE(render_to(4000, 1));
    finish(film.passes());
    const std::vector<CurvePoint>& curve = follower->curve();
    ASSERT_GE(curve.size(), 2u);
    for (const CurvePoint& point : std::span(curve).last(2)) {
        ASSERT_TRUE(point.metrics.at("flip_ldr")) << point.passes;
        EXPECT_LE(*point.metrics.at("flip_ldr"), 0.1);
        EXPECT_TRUE(point.metrics.at("mae"));
    }
}

/// 500 jobs each against references of a third and of three times the noise that the film has where it reaches its
/// target. One look lies below by luck with a probability of 5 %, what a two-sided interval of 90 % leaves on that
/// side; looks at a film that has hardly changed err alike, and those at one that has changed are few before the target
/// is reached. So no more jobs may end early than one look would end, and what binomial scatter adds to that with a
/// probability of 1e-6.
TEST_F(ErrorFollowerTest, AJobDoesNotEndEarlyByLuck) {
    constexpr uint32_t kJobs = 500;
    constexpr double kPassVariance = 1.0 / 12, kTarget = kPassVariance / 60;
    for (const double of_film : {0.3, 3.0}) {
        std::mt19937_64 random(20261125);
        std::normal_distribution<float> normal(0, static_cast<float>(of_film * std::sqrt(kTarget)));
        request.stop.target = ErrorTarget{"mse", kTarget};
        uint32_t early = 0, unmet = 0;
        double sum_of_passes = 0;
        for (uint32_t job = 0; job < kJobs; ++job) {
            LoadedReference reference;
            reference.second.emplace();
            for (ReferenceImage* image : {&reference.first, &*reference.second}) {
                image->size = kSize;
                image->layers["beauty"] = ramp();
                for (float& value : image->layers["beauty"]) value += normal(random);
            }
            film = Film{kSize, LayerSet(), 1000 * job};
            make(std::optional(std::move(reference)));
            bool met = false;
            while (!met && film.passes() < 600) {
                film.add_pass(noisy_pass(film.next_pass()));
                met = follower->after_pass(film, film.passes());
            }
            unmet += !met;
            sum_of_passes += film.passes();
            early += met && *ErrorMeter(kSize, ramp()).pointwise(film.resolve_beauty())[Metric::Mse] > kTarget;
        }
        std::printf(
            "references of %g times the film's noise: %u of %u jobs ended early, %u not at all, after %.0f "
            "passes in the mean\n",
            of_film, early, kJobs, unmet, sum_of_passes / kJobs);
        EXPECT_LE(early, kJobs * (0.05 + 4.9 * std::sqrt(0.05 * 0.95 / kJobs))) << of_film;
        EXPECT_LT(unmet, kJobs / 2) << "or it shows nothing";
    }
}

TEST_F(ErrorFollowerTest, TargetsAreLookedAtAgainAfterFivePercentMorePasses) {
    request.stop.target = ErrorTarget{"mae", 0};
    make(ramp());
    render_to(64, 1);
    finish(64);
    readings = 0;
    size_t looked_at = 0;
    for (uint32_t last = 64; film.passes() < 120;) {
        const size_t before = readings, points = follower->curve().size();
        render_to(film.passes() + 1, 1);
        if (readings == before) continue;
        ++looked_at;
        if (follower->curve().size() == points) {
            EXPECT_EQ(film.passes(), std::ceil(1.05 * last));
        }
        last = film.passes();
    }
    EXPECT_GE(looked_at, 10u);
}

TEST_F(ErrorFollowerTest, AMetricWithoutAValueMeetsNothing) {
    const std::vector<float> black(3 * kSize.pixels(), 0.0f);
    request.stop.target = ErrorTarget{"relative_mse", 1e30};
    make(black);
    EXPECT_FALSE(render_to(20, 1));
    finish(20);
    EXPECT_FALSE(follower->curve().back().metrics.at("relative_mse").has_value());
    EXPECT_FALSE(follower->error_now());
    film = Film{kSize, LayerSet()};
    request.stop.target = ErrorTarget{"rmse", 1e30};
    make(black);
    EXPECT_TRUE(render_to(20, 1));
    EXPECT_EQ(film.passes(), 2u);
}

TEST_F(ErrorFollowerTest, GoesOnFromAFilm) {
    make(ramp());
    render_to(20, 0.001);
    const std::vector<CurvePoint> undisturbed = follower->curve();
    for (const uint32_t saved : {1u, 3u, 8u, 15u}) {
        film = Film{kSize, LayerSet()};
        make(ramp());
        render_to(saved, 0.001);
        const std::vector<CurvePoint> before =
            FilmHistory::parse(FilmHistory{0.001 * saved, {}, {}, {}, follower->curve(), {}}.text()).curve;
        make(ramp());
        EXPECT_FALSE(follower->go_on_from(film, before, 0.001 * saved));
        EXPECT_EQ(follower->error_now()->value, *before.back().metrics.at("relative_mse"));
        render_to(20, 0.001);
        ASSERT_EQ(point_passes(), (std::vector<uint32_t>{1, 2, 4, 8, 16}));
        for (size_t i = 0; i < undisturbed.size(); ++i)
            EXPECT_EQ(follower->curve()[i].metrics.at("relative_mse"), undisturbed[i].metrics.at("relative_mse"));
    }
    request.stop.target = ErrorTarget{"mae", 1};
    make(ramp());
    EXPECT_FALSE(follower->go_on_from(film, {}, 0.02)) << "it was looked at once";
    make(ramp());
    EXPECT_TRUE(follower->go_on_from(film, undisturbed, 0.02));
}

TEST_F(ErrorFollowerTest, AReferenceMustHaveTheSizeAndTheLayers) {
    ReferenceImage reference;
    reference.size = {8, 8};
    reference.layers["beauty"].resize(3 * 64);
    EXPECT_THROW(make(std::optional(LoadedReference{reference, {}})), Error);
    request.metrics = {"indirect:rmse"};
    EXPECT_THROW(make(ramp()), Error);
}

TEST(FilmHistory, IsReadAsWritten) {
    FilmHistory history;
    history.seconds = 0.1;
    history.counts.camera_rays = UINT64_MAX, history.counts.infinite_samples = 3;
    history.stages = {{"walk", 0.25, 0.5, 0.125}};
    history.skipped = {{"what", "why \xff", 7}};
    history.curve = {{0.1, 1, 200, {{"rmse", 1e-7}, {"flip_ldr", std::nullopt}}, {{"rmse", {0, 2e-7}}}},
                     {0.2, 2, std::nullopt, {}}};
    history.standard_error_scale = 0.7;
    const FilmHistory read = FilmHistory::parse(history.text());
    EXPECT_EQ(read.text(), history.text());
    EXPECT_EQ(read.counts.camera_rays, UINT64_MAX);
    EXPECT_EQ(read.curve[0].metrics.at("rmse"), 1e-7);
    EXPECT_EQ(read.curve[0].photons, 200u);
    EXPECT_EQ(read.curve[0].intervals.at("rmse"), (Interval{0, 2e-7}));
    EXPECT_EQ(FilmHistory::parse("").curve.size(), 0u);
    for (const char* damaged : {"{", "[]", "{\"seconds\": \"x\"}", "7"})
        EXPECT_THROW((void)FilmHistory::parse(damaged), Error) << damaged;

    FilmHistory sum = read;
    sum += read;
    EXPECT_EQ(sum.seconds, 0.2);
    EXPECT_EQ(sum.counts.infinite_samples, 6u);
    EXPECT_EQ(sum.stages.size(), 1u);
    EXPECT_EQ(sum.stages[0].cpu_seconds, 1.0);
    EXPECT_EQ(sum.skipped.size(), 1u);
    EXPECT_TRUE(sum.curve.empty() && !sum.standard_error_scale);
}

TEST(FilmSaverTest, SavesAtMostTwoPercentOfTheTime) {
    const TemporaryFolder folder;
    Stats stats;
    RenderMeters meters;
    double time = 0, cost = 0;
    FilmSaver saver({"scene", "settings", "device"}, 1.0, stats, meters, [&] {
        const double now = time;
        time += cost;
        return now;
    });
    const Film film{kSize, LayerSet()};
    time = 0.5;
    EXPECT_FALSE(saver.due(film));
    time = 1.0;
    EXPECT_TRUE(saver.due(film));
    cost = 0.1;  // a saving takes so long
    saver.save(film, "", folder.path() / "film");
    cost = 0;
    time = 1.1 + 4.9;
    EXPECT_FALSE(saver.due(film));
    time = 1.1 + 5.1;
    EXPECT_TRUE(saver.due(film));
    EXPECT_EQ(FilmFile::load(folder.path() / "film").identity, saver.identity());
    EXPECT_GT(stats.stage(kFilmSavingStage).wall_seconds, 0);
    EXPECT_FALSE(FilmSaver({}, std::nullopt, stats, meters, [] { return 1e9; }).due(film));
}

}  // namespace
}  // namespace photond::error_follower_test
