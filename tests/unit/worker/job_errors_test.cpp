// Whole jobs against references, and jobs that go on from films of earlier attempts.

#include <algorithm>
#include <bit>
#include <fstream>
#include <thread>

#include "renderer/error/cross_meter.h"
#include "renderer/film/exr_file.h"
#include "server/worker/error_follower.h"
#include "server/worker/film_history.h"
#include "tests/support/film_versions.h"
#include "tests/support/job_runs.h"
#include "tests/support/temporary_folder.h"

namespace photond::job_errors_test {
namespace {

using nlohmann::json;

class JobErrors : public test::JobRuns {
protected:
    std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }

    /// Renders a reference of that many passes and keeps its film.
    json reference(uint32_t passes) {
        json message = order({{"stop", {{"passes", passes}}}});
        message["streams"] = "reference";
        message["film"] = path("reference.film").string();
        EXPECT_EQ(run(message)["state"], "succeeded");
        return {{"film", path("reference.film").string()}};
    }
    json measured_order(const json& reference, const json& changes = json::object()) const {
        json message = order(changes);
        message["request"]["reference"] = "job:J7";
        message["reference"] = reference;
        return message;
    }
    /// Runs the job for that many passes and keeps its film, as a worker does that is stopped then.
    void save_after(const json& message, uint32_t passes, const std::string& name) {
        const std::filesystem::path so_far = path("so_far.film");
        JobControl control;
        on_message = [&](const json& told) {
            const bool saved = told["type"] == "film_saved" && told["path"] == so_far.string();
            if (saved && told["passes_done"] == passes) {
                control.stopping = true;
                control.cancel.cancel();
            } else if (saved || told["type"] == "started") {
                control.film_so_far.ask(so_far);
            }
        };
        run(message, control);  // cancelled, unless it was done
        on_message = nullptr;
        std::filesystem::remove(so_far);
        std::filesystem::rename(film_path(), path(name));
        EXPECT_EQ(FilmFile::load(path(name)).film.passes(), passes);
    }
    json resumed(json message, const std::string& name) {
        message["resume"] = path(name).string();
        return run(message);
    }
    std::vector<json> points_sent() const {
        std::vector<json> points;
        for (const json& message : sent)
            if (message["type"] == "curve")
                for (const json& point : message["points"]) points.push_back(point);
        return points;
    }
    static std::string hash(const json& finished) { return finished["statistics"]["pixel_hash"]; }
    static bool logged(const json& finished, const std::string& text) {
        for (const json& line : finished["log"])
            if (line.get<std::string>().find(text) != std::string::npos) return true;
        return false;
    }
    /// Of the points at powers of two and at the end of nine passes; others go by the time.
    static std::map<uint32_t, double> errors_by_passes(const json& curve) {
        std::map<uint32_t, double> errors;
        for (const json& point : curve) {
            const uint32_t passes = point["passes"];
            if (std::has_single_bit(passes) || passes == 9) errors[passes] = point["metrics"]["relative_mse"];
        }
        return errors;
    }

private:
    TemporaryFolder folder_;
};

TEST_F(JobErrors, ReferencesDrawNumbersOfTheirOwn) {
    json message = order();
    const std::string own = hash(run(message));
    message["streams"] = "reference";
    const std::string reference = hash(run(message));
    EXPECT_NE(reference, own);
    EXPECT_EQ(hash(run(message)), reference);
    message["request"]["seed"] = 2u;
    EXPECT_NE(hash(run(message)), reference);
    message = order();
    message["streams"] = "job";
    EXPECT_EQ(hash(run(message)), own);
    message["streams"] = "other";
    EXPECT_EQ(run(message)["failure"]["code"], "unknown_name");
}

TEST_F(JobErrors, TheErrorOfTheFinalFilmIsInTheStatistics) {
    const json source = reference(32);
    json message = measured_order(source, {{"stop", {{"passes", 5}}}});
    message["request"]["metrics"] = {"flip_hdr", "indirect:rmse"};
    const json finished = run(message);
    ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
    const Film film = FilmFile::load(film_path()).film;
    const Film judge = FilmFile::load(path("reference.film")).film;
    const ErrorMeter meter(film.size(), judge.resolve_beauty());
    const std::vector<float> image = film.resolve_beauty();
    const json& error = finished["statistics"]["error"];
    for (const MetricInfo& info : kMetrics) {
        if (!info.needs_reference || info.metric == Metric::FlipLdr || info.values == 4) continue;
        const std::vector<double> expected = meter.measure(info.metric, image);
        const json& value = error[std::string(info.name)];
        const std::vector<double> found =
            info.values == 1 ? std::vector{value.get<double>()} : value.get<std::vector<double>>();
        EXPECT_EQ(found, expected) << info.name;
    }
    EXPECT_FALSE(error.contains("flip_ldr"));
    EXPECT_EQ(error["percentiles"]["90"], meter.percentiles(image)->at(1));
    for (const auto& [name, of] : {std::pair{"bias_standard_error", PassMeans::Of::Beauty},
                                   std::pair{"indirect:bias_standard_error", PassMeans::Of::Indirect}})
        for (size_t k = 0; k < 3; ++k)
            EXPECT_DOUBLE_EQ(error[name][k], std::sqrt(film.pass_means().variance(of)->at(k) / 5)) << name;
    const ErrorMeter indirect(film.size(), judge.resolve(Layer::Indirect));
    const PointwiseErrors of_indirect = indirect.pointwise(film.resolve(Layer::Indirect));
    EXPECT_EQ(error["indirect:rmse"], *of_indirect[Metric::Rmse]);
    EXPECT_EQ(error["indirect:relative_mse"], *of_indirect[Metric::RelativeMse]);
    EXPECT_EQ(error["left_out"], 0);

    const json& noise = finished["statistics"]["reference_error"];
    for (const char* metric : {"relative_mse", "rmse", "flip_hdr", "indirect:mae"})
        EXPECT_GT(noise[metric].get<double>(), 0) << metric;
    EXPECT_LT(noise["rmse"], error["rmse"]);
    const json& about = finished["statistics"]["reference"];
    EXPECT_EQ(about["source"], "job:J7");
    EXPECT_EQ(about["passes"], 32);
    EXPECT_EQ(about["flip_version"], kFlipVersion);
    const json& estimate = finished["statistics"]["estimate"];
    EXPECT_GT(estimate["estimated_relative_mse"], 0);
    EXPECT_EQ(estimate["confidence"], kConfidence);
    EXPECT_GT(estimate["within_confidence"], 0.5);
    EXPECT_LE(estimate["within_confidence"], 1);
    EXPECT_EQ(finished["error_now"]["value"], error["relative_mse"]);
    EXPECT_TRUE(run(order())["statistics"]["error"].is_null());
}

TEST_F(JobErrors, TheCurveIsSentPointByPointAndMeasuringIsOffTheClock) {
    json message = measured_order(reference(16), {{"stop", {{"passes", 11}}}});
    message["request"]["metrics"] = {"flip_hdr"};
    const json finished = run(message);
    const std::vector<json> points = points_sent();
    ASSERT_EQ(json(points).size(), finished["curve"].size());
    std::vector<uint32_t> passes;
    for (size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(points[i]["metrics"]["relative_mse"], finished["curve"][i]["metrics"]["relative_mse"]);
        EXPECT_TRUE(points[i]["photons"].is_null());
        if (std::has_single_bit(points[i]["passes"].get<uint32_t>())) passes.push_back(points[i]["passes"]);
    }
    EXPECT_EQ(passes, (std::vector<uint32_t>{1, 2, 4, 8}));
    EXPECT_EQ(points.back()["passes"], 11);
    EXPECT_EQ(points.back()["seconds"], finished["seconds"]);
    EXPECT_TRUE(finished["curve"].back()["metrics"]["flip_hdr"].is_number());
    double in_clock = 0, measuring = 0;
    for (const json& stage : finished["statistics"]["stages"]) {
        const double seconds = stage["wall_seconds"];
        if (!test::is_off_the_clock(stage["name"])) in_clock += seconds;
        if (stage["name"] == "error_measuring") measuring += seconds;
    }
    EXPECT_GT(measuring, 0);
    EXPECT_GT(in_clock, 0);
    EXPECT_LE(in_clock, 1.02 * finished["seconds"].get<double>());
    run(photon_order());
    EXPECT_EQ(points_sent().back()["photons"], 3 * 2000);
}

TEST_F(JobErrors, AWarningWhereTheReferenceIsNoBetter) {
    const json source = reference(8);
    const json alike = run(measured_order(source, {{"stop", {{"passes", 8}}}}));
    EXPECT_TRUE(logged(alike, "rmse is ") && logged(alike, "times what the reference's own noise explains"))
        << alike["log"].dump(1);
    EXPECT_FALSE(alike["statistics"]["reference"]["warnings"].empty());
    const json worse = run(measured_order(reference(256), {{"stop", {{"passes", 1}}}}));
    EXPECT_FALSE(logged(worse, "own noise explains")) << worse["log"].dump(1);
    EXPECT_TRUE(worse["statistics"]["reference"]["warnings"].empty());
}

TEST_F(JobErrors, ImagesAreReferencesWhoseNoiseIsUnknown) {
    reference(8);
    write_exr(FilmFile::load(path("reference.film")).film, Precision::Float, {}, path("reference.exr"));
    const json image{{"image", path("reference.exr").string()}};
    const json finished = run(measured_order(image));
    ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
    EXPECT_EQ(finished["statistics"]["error"]["rmse"],
              run(measured_order({{"film", path("reference.film").string()}}))["statistics"]["error"]["rmse"]);
    EXPECT_TRUE(finished["statistics"]["reference_error"]["rmse"].is_null());
    EXPECT_TRUE(finished["statistics"]["reference"]["passes"].is_null());
    EXPECT_EQ(finished["statistics"]["reference"]["notes"].size(), 2u);  // its noise is in the errors, and not known
    EXPECT_EQ(finished["statistics"]["reference"]["form"], "image");

    const json small = run(measured_order(image, {{"image", {{"width", 8}, {"height", 8}}}}));
    EXPECT_EQ(small["failure"]["code"], "conflict");
    EXPECT_EQ(small["failure"]["errors"][0]["pointer"], "/reference");
    EXPECT_EQ(run(measured_order({{"image", path("none.exr").string()}}))["failure"]["code"], "bad_image");
    EXPECT_EQ(run(measured_order(nullptr))["failure"]["code"], "internal");
}

TEST_F(JobErrors, OnePassTellsNothingOfItsSpread) {
    const json statistics = run(measured_order(
        reference(8), {{"stop", {{"passes", 1}}}, {"layers", {"standard_error", "caustic"}}}))["statistics"];
    EXPECT_TRUE(statistics["estimate"].is_null());
    EXPECT_TRUE(statistics["error"]["bias"][0].is_number());
    EXPECT_TRUE(statistics["error"]["bias_standard_error"].is_null());
    EXPECT_NE(statistics["reference"]["notes"].dump().find("bias_standard_error: unknown after one pass"),
              std::string::npos)
        << statistics["reference"]["notes"];
    for (const json& point : points_sent())
        EXPECT_TRUE(point["metrics"].value("estimated_relative_mse", json()).is_null());

    for (const Precision precision : {Precision::Float, Precision::Half}) {
        const uint64_t overflowed = write_exr(FilmFile::load(film_path()).film, precision, {}, path("one.exr"));
        EXPECT_EQ(overflowed, 0u);  // it was infinite before
        const LayeredImage image = read_image(path("one.exr"));
        for (const float error : image.layers.at("standard_error")) ASSERT_TRUE(std::isinf(error));
    }
}

TEST_F(JobErrors, PassesDoNotSayHowFarABiasIsKnownThatLeavesValuesOut) {
    reference(8);
    std::vector<float> pixels = FilmFile::load(path("reference.film")).film.resolve_beauty();
    pixels[100] = std::nanf("");
    write_exr({24, 16}, {{channel_names("beauty"), pixels}}, Precision::Float, {}, path("reference.exr"));
    const json statistics = run(measured_order({{"image", path("reference.exr").string()}}))["statistics"];
    EXPECT_EQ(statistics["error"]["left_out"], 1);
    EXPECT_TRUE(statistics["error"]["bias"][0].is_number());
    EXPECT_TRUE(statistics["error"]["bias_standard_error"].is_null());
    const json& notes = statistics["reference"]["notes"];
    EXPECT_NE(
        std::find(notes.begin(), notes.end(), "bias_standard_error: unknown, for passes keep the mean over all values"),
        notes.end())
        << notes;
}

TEST_F(JobErrors, AJobEndsWhenItsTargetIsMet) {
    const json source = reference(64);
    const json longer = run(measured_order(source, {{"stop", {{"passes", 16}}}}));
    const double goal = longer["curve"].back()["metrics"]["relative_mse"].get<double>() * 1.0001;
    const json finished = run(measured_order(
        source, {{"stop", {{"passes", 1000}, {"target", {{"metric", "relative_mse"}, {"value", goal}}}}}}));
    EXPECT_EQ(finished["state"], "succeeded");
    EXPECT_GT(finished["passes_done"], 1);
    EXPECT_LE(finished["passes_done"], 64) << "twice the passes that meet it, and as many again by luck";
    EXPECT_EQ(finished["error_now"]["metric"], "relative_mse");
    EXPECT_LE(finished["error_now"]["value"], goal);
    const json& curve = finished["curve"];  // has the looks that met it, which may not be next to each other
    ASSERT_GE(curve.size(), 2u);
    for (size_t i = curve.size() - 2; i < curve.size(); ++i) EXPECT_LE(curve[i]["metrics"]["relative_mse"], goal) << i;
    const uint32_t passes = finished["passes_done"];
    EXPECT_EQ(hash(run(order({{"stop", {{"passes", passes}}}}))), hash(finished));
}

/// Two films of the seeds that the daemon asks for, each noisier than what is measured.
TEST_F(JobErrors, TwoFilmsMeasureWithoutTheirNoise) {
    const std::filesystem::path first = path("first.film");
    for (const uint32_t seed : {2u, 1u}) {
        json message = order({{"seed", seed}, {"stop", {{"passes", 4}}}});
        message["streams"] = "reference";
        message["film"] = (seed == 2 ? path("second.film") : first).string();
        ASSERT_EQ(run(message)["state"], "succeeded");
    }
    const json films{{"film", first.string()}, {"second", {{"film", path("second.film").string()}}}};
    const json finished = run(measured_order(films, {{"stop", {{"passes", 64}}}}));
    ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
    const json& statistics = finished["statistics"];
    const Film u = FilmFile::load(first).film, v = FilmFile::load(path("second.film")).film;
    const Film film = FilmFile::load(finished["film"].get<std::string>()).film;
    const CrossMeter meter(film.size(), u.resolve_beauty(), v.resolve_beauty());
    const CrossErrors errors = meter.measure(film.resolve_beauty());
    EXPECT_EQ(statistics["error"]["mse"], errors.mse->value);
    EXPECT_EQ(statistics["error"]["relative_mse"], errors.relative_mse->value);
    EXPECT_DOUBLE_EQ(statistics["error_interval"]["mse"][1], errors.mse->interval().greatest);
    EXPECT_EQ(statistics["error"]["rmse"].is_null(), errors.mse->value < 0);
    const std::span<const float> mean = meter.mean_reference();
    const ErrorMeter usual(film.size(), std::vector<float>(mean.begin(), mean.end()));
    EXPECT_EQ(statistics["error"]["mae"], usual.measure(Metric::Mae, film.resolve_beauty()).front());
    EXPECT_NEAR(statistics["reference_error"]["mae"], usual.measure(Metric::Mae, u.resolve_beauty()).front(), 1e-6);
    EXPECT_EQ(statistics["reference"]["form"], "two_films");
    EXPECT_EQ(statistics["reference"]["passes"], 8);
    EXPECT_EQ(statistics["reference"]["denominators"]["relative_mse"], "neighbours");
    EXPECT_EQ(finished["curve"].back()["intervals"]["mse"], statistics["error_interval"]["mse"]);
    // What is saved with the film has them too.
    json again = measured_order(films, {{"stop", {{"passes", 64}}}});
    again["resume"] = finished["film"];
    EXPECT_EQ(run(again)["curve"].back()["intervals"], finished["curve"].back()["intervals"]);
    EXPECT_EQ(run(measured_order({{"film", first.string()}, {"second", {{"film", "/none"}}}}))["failure"]["code"],
              "result_lost");
}

TEST_F(JobErrors, AJobThatGoesOnHasTheSameBitsAndPoints) {
    const json whole = measured_order(reference(16), {{"stop", {{"passes", 9}}}});
    const json undisturbed = run(whole);
    for (const uint32_t passes : {1u, 3u, 8u, 9u}) {
        save_after(whole, passes, "saved.film");
        const json finished = resumed(whole, "saved.film");
        ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
        EXPECT_EQ(hash(finished), hash(undisturbed));
        EXPECT_EQ(finished["statistics"]["resumed_passes"], passes);
        EXPECT_EQ(finished["statistics"]["counts"]["rays"], undisturbed["statistics"]["counts"]["rays"]);
        EXPECT_GT(finished["seconds"], FilmHistory::parse(FilmFile::load(path("saved.film")).history).seconds * 0.999);
        EXPECT_EQ(errors_by_passes(finished["curve"]), errors_by_passes(undisturbed["curve"]));
        EXPECT_EQ(points_sent().size(), finished["curve"].size());  // the first ones are sent again
        EXPECT_TRUE(logged(finished, "goes on from a film of " + std::to_string(passes) + " passes"));
        EXPECT_EQ(FilmFile::load(film_path()).film.pixel_hash(), hash(undisturbed));
    }
    // 9 of 9: nothing was left to be rendered, and no stage of the second attempt says otherwise.
    const json done = resumed(whole, "saved.film");
    EXPECT_EQ(done["seconds"], FilmHistory::parse(FilmFile::load(path("saved.film")).history).seconds);
    json target = whole;
    target["request"]["stop"] = {{"passes", 100}, {"target", {{"metric", "rmse"}, {"value", 1e9}}}};
    EXPECT_EQ(resumed(target, "saved.film")["passes_done"], 9);
    EXPECT_EQ(FilmFile::load(film_path()).film.passes(), 9u);
}

// Its passes' means are not in it: what follows from all passes' is not claimed, and all else is as ever.
TEST_F(JobErrors, AJobGoesOnFromAFilmThatAnOlderVersionSaved) {
    const json whole = measured_order(reference(16), {{"stop", {{"passes", 9}}}});
    const json undisturbed = run(whole);
    save_after(whole, 3, "saved.film");
    std::string bytes(std::istreambuf_iterator<char>(std::ifstream(path("saved.film"), std::ios::binary).rdbuf()), {});
    bytes = test::film_of_version(bytes, 5);
    std::ofstream(path("saved.film"), std::ios::binary | std::ios::trunc) << bytes;
    const json finished = resumed(whole, "saved.film");
    ASSERT_EQ(finished["state"], "succeeded") << finished.dump(1);
    EXPECT_EQ(finished["statistics"]["resumed_passes"], 3);
    EXPECT_EQ(hash(finished), hash(undisturbed));
    EXPECT_EQ(errors_by_passes(finished["curve"]), errors_by_passes(undisturbed["curve"]));
    json error = finished["statistics"]["error"], expected = undisturbed["statistics"]["error"];
    EXPECT_EQ(expected["bias_standard_error"].size(), 3u);
    EXPECT_TRUE(error["bias_standard_error"].is_null());
    for (const char* other : {"bias_standard_error", "estimated_relative_mse"})  // by what it saw on the way
        error.erase(other), expected.erase(other);
    EXPECT_EQ(error, expected);
    json notes = finished["statistics"]["reference"]["notes"];
    const auto said = std::find(notes.begin(), notes.end(),
                                "bias_standard_error: unknown, for 3 of the 9 passes are from a film that an older "
                                "version saved, without their means");
    ASSERT_NE(said, notes.end()) << notes;
    notes.erase(said);
    EXPECT_EQ(notes, undisturbed["statistics"]["reference"]["notes"]);
    const Film film = FilmFile::load(film_path()).film;
    EXPECT_EQ(film.passes(), 9u);
    EXPECT_EQ(film.pass_means().passes(), 6u);
}

TEST_F(JobErrors, AFinishedFilmIsExtended) {
    run(order({{"stop", {{"passes", 2}}}}));
    std::filesystem::rename(film_path(), path("short.film"));
    const json longer = order({{"stop", {{"passes", 5}}}, {"priority", 7}, {"labels", {{"a", "b"}}}});
    const json extended = resumed(longer, "short.film");
    EXPECT_EQ(extended["statistics"]["resumed_passes"], 2);
    const json whole = run(longer);
    EXPECT_EQ(hash(extended), hash(whole));
    EXPECT_EQ(extended["statistics"]["settings_hash"], whole["statistics"]["settings_hash"]);
}

TEST_F(JobErrors, OtherFilmsAreNamedAndTheJobBeginsAnew) {
    const json whole = order({{"stop", {{"passes", 4}}}});
    const json undisturbed = run(whole);
    EXPECT_TRUE(undisturbed["statistics"]["resumed_passes"] == 0);
    const auto begins_anew = [&](const std::string& name, const std::string& why) {
        const json finished = resumed(whole, name);
        EXPECT_EQ(finished["state"], "succeeded");
        EXPECT_EQ(hash(finished), hash(undisturbed)) << name;
        EXPECT_EQ(finished["statistics"]["resumed_passes"], 0) << name;
        EXPECT_EQ(finished["statistics"]["counts"]["rays"], undisturbed["statistics"]["counts"]["rays"]) << name;
        EXPECT_TRUE(logged(finished, "begins anew") && logged(finished, why)) << finished["log"].dump(1);
    };
    begins_anew("missing.film", "cannot be opened");
    const auto changed = [&](const json& changes) {
        save_after(order(changes), 2, "other.film");
        return "other.film";
    };
    begins_anew(changed({{"seed", 2u}}), "settings");
    begins_anew(changed({{"layers", {"depth"}}}), "settings");
    begins_anew(changed({{"image", {{"filter", "gaussian"}}}}), "settings");
    begins_anew(changed({{"first_pass", 1}}), "passes 1-2");
    save_after(whole, 2, "good.film");
    SavedFilm film = FilmFile::load(path("good.film"));
    FilmFile::save(film.film, {"another scene", film.identity.settings, film.identity.device}, film.history,
                   path("scene.film"));
    begins_anew("scene.film", "scene");
    FilmFile::save(film.film, {film.identity.scene, film.identity.settings, "another machine"}, film.history,
                   path("device.film"));
    begins_anew("device.film", "device");
    FilmFile::save(film.film, film.identity, "{}", path("history.film"));
    begins_anew("history.film", "history");
    std::fstream damaged(path("good.film"), std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(static_cast<std::streamoff>(std::filesystem::file_size(path("good.film")) / 2));
    damaged.put('\x5a').put('\x5a');
    damaged.close();
    begins_anew("good.film", "damaged");
}

TEST_F(JobErrors, PartsOfAJobAreItsPasses) {
    const json whole = run(order({{"stop", {{"passes", 7}}}}));
    run(order({{"stop", {{"passes", 3}}}}));
    Film joined = FilmFile::load(film_path()).film;
    const json part = order({{"stop", {{"passes", 4}}}, {"first_pass", 3}});
    const json second = run(part);
    EXPECT_EQ(second["passes_done"], 4);
    EXPECT_EQ(second["statistics"]["pass_ranges"], json({{3, 7}}));
    EXPECT_EQ(second["statistics"]["settings_hash"], whole["statistics"]["settings_hash"]);
    EXPECT_NE(second["statistics"]["job_hash"], whole["statistics"]["job_hash"]);
    joined.merge(FilmFile::load(film_path()).film);
    EXPECT_EQ(joined.pixel_hash(), hash(whole));
    save_after(part, 2, "part.film");
    const json resumed_part = resumed(part, "part.film");
    EXPECT_EQ(resumed_part["statistics"]["resumed_passes"], 2);
    EXPECT_EQ(hash(resumed_part), hash(second));
}

TEST_F(JobErrors, TheFilmIsSavedWhileTheJobRuns) {
    json message = order({{"stop", {{"seconds", 0.3}, {"passes", nullptr}}}});
    message["save_seconds"] = 0;
    const json finished = run(message);
    size_t saved = 0;
    for (const json& told : sent) saved += told["type"] == "film_saved" && told["path"] == film_path().string();
    EXPECT_GE(saved, 1u);
    bool staged = false;
    for (const json& stage : finished["statistics"]["stages"]) staged |= stage["name"] == "film_saving";
    EXPECT_TRUE(staged);
    message["save_seconds"] = nullptr;
    message["request"]["stop"] = {{"passes", 3}};
    run(message);
    for (const json& told : sent) EXPECT_NE(told["type"], "film_saved");
}

TEST(FilmIdentityTest, IsOfWhatDecidesThePixels) {
    JobRequest request;
    request.scene = "box", request.width = 8, request.height = 8, request.method.name = "path_tracing";
    request.layers = {"depth", "albedo"}, request.stop.passes = 4;
    const std::string hash = settings_hash(request, RandomStreams::Job);
    EXPECT_NE(settings_hash(request, RandomStreams::Reference), hash);
    JobRequest same = request;
    same.scene = "another name", same.stop.passes = 9, same.first_pass = 3, same.priority = 1, same.labels["a"] = "b";
    same.reference.emplace().job = "J1", same.metrics = {"rmse"}, same.layers = {"albedo", "depth"};
    EXPECT_EQ(settings_hash(same, RandomStreams::Job), hash);
    JobRequest other = request;
    other.time = 1;
    EXPECT_NE(settings_hash(other, RandomStreams::Job), hash);
    const Device device = open_device({"cpu", {}, 0});
    const FilmIdentity identity = film_identity(request, "id", RandomStreams::Job, device);
    EXPECT_EQ(identity.scene, "id");
    EXPECT_NE(identity.device.find(device.name), std::string::npos);
    EXPECT_NE(identity.device.find(PHOTOND_VERSION), std::string::npos);
    Device another = device;
    another.name += " of another model";
    EXPECT_NE(device_class(another), device_class(device));
}

}  // namespace
}  // namespace photond::job_errors_test
