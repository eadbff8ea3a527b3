#include "protocol/job.h"

#include <gtest/gtest.h>

#include <random>

#include "protocol/error.h"
#include "tests/support/job_vocabulary.h"

namespace photond::job_request_test {
namespace {

using nlohmann::json;

JobVocabulary vocabulary() { return test::job_vocabulary(); }

json smallest() {
    return json::parse(R"({"scene": "cornell-box", "image": {"width": 64, "height": 32},
                           "method": {"name": "path_tracing"}, "stop": {"passes": 4}})");
}

std::vector<std::string> pointers_of(const json& body, ErrorCode* code = nullptr) {
    try {
        parse_job_request(body, vocabulary());
    } catch (const Error& error) {
        std::vector<std::string> pointers;
        for (const Fault& fault : error.faults) pointers.push_back(fault.pointer);
        if (code != nullptr) *code = error.code;
        return pointers;
    }
    return {"accepted"};
}

json with(const char* pointer, const char* value) {
    json body = smallest();
    body[json::json_pointer(pointer)] = json::parse(value);
    return body;
}

TEST(JobRequest, FillsInEveryDefault) {
    const json echo = to_json(parse_job_request(smallest(), vocabulary()));
    EXPECT_EQ(echo, json::parse(R"({
        "scene": "cornell-box",
        "camera": {"name": null, "look_at": null, "aperture": 0, "focus_distance": null},
        "image": {"width": 64, "height": 32, "filter": "box"},
        "method": {"name": "path_tracing", "device": "cpu", "parameters": {"bounces": 8, "radius": 0.05}},
        "stop": {"seconds": null, "passes": 4, "target": null}, "first_pass": 0,
        "seed": 1, "layers": [], "reference": null, "metrics": [], "priority": 0, "quiet_machine": null,
        "labels": {}, "environment": null,
        "glass": "as_stored", "animation": null, "time": 0, "shutter": 0})"));
}

TEST(JobRequest, ReadsEveryField) {
    const json body = json::parse(R"({
        "scene": "s", "camera": {"look_at": {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 0, 1], "yfov": 0.5},
                                 "aperture": 0.01, "focus_distance": 2.5},
        "image": {"width": 65536, "height": 1, "filter": "gaussian"},
        "method": {"name": "photon_mapping", "device": "gpu:3", "parameters": {"bounces": 0}},
        "stop": {"seconds": 0.5, "passes": 7, "target": {"metric": "indirect:rmse", "value": 0.25}}, "first_pass": 3,
        "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 9}}, "metrics": ["caustic:relative_mse"],
        "seed": 18446744073709551615, "layers": ["depth", "albedo", "caustic"],
        "priority": -100, "quiet_machine": 2.5, "labels": {"a/b": "c", "~": ""}, "environment": {"image": "image:i1", "scale": 2, "rotation": -1},
        "glass": "solid", "animation": "walk", "time": 1.5, "shutter": 0.02})");
    const JobRequest request = parse_job_request(body, vocabulary());
    EXPECT_EQ(request.camera.look_at->up[2], 1);
    EXPECT_EQ(request.method.device, "gpu:3");
    EXPECT_EQ(request.seed, UINT64_MAX);
    EXPECT_EQ(request.layers, (std::vector<std::string>{"depth", "albedo", "caustic"}));
    EXPECT_EQ(request.stop.target->metric, "indirect:rmse");
    EXPECT_EQ(request.stop.target->value, 0.25);
    EXPECT_EQ(request.first_pass, 3u);
    EXPECT_EQ(request.reference->rendering->method.parameters.dump(), R"({"bounces":8,"radius":0.05})");
    EXPECT_EQ(request.reference->rendering->stop.passes, 9u);
    EXPECT_EQ(request.metrics, std::vector<std::string>{"caustic:relative_mse"});
    EXPECT_EQ(request.labels.at("a/b"), "c");
    EXPECT_EQ(request.environment->rotation, -1);
    EXPECT_EQ(request.animation->name, "walk");
    EXPECT_EQ(request.time, 1.5);
    EXPECT_EQ(request.shutter, 0.02);
    EXPECT_EQ(request.method.parameters.dump(), R"({"bounces":0,"radius":0.05})");
}

// parse(to_json(r)) == r: shown by the echo of the echo, which holds every field.
TEST(JobRequest, TheEchoIsAFixedPoint) {
    std::mt19937_64 random(7);
    const auto chance = [&] { return random() % 2 == 0; };
    std::uniform_real_distribution<double> number(-100, 100);
    for (int i = 0; i < 2000; ++i) {
        json body = smallest();
        body["image"] = {{"width", random() % 16384 + 1}, {"height", random() % 16384 + 1}};
        body["seed"] = random();
        if (chance()) body["camera"]["name"] = "main";
        if (chance())
            body["camera"] = {{"look_at",
                               {{"eye", {number(random), number(random), 200}},
                                {"target", {number(random), number(random), number(random)}}}}};
        if (chance()) body["camera"]["aperture"] = 0.0;
        if (chance()) body["camera"]["focus_distance"] = std::abs(number(random)) + 1;
        if (chance()) body["stop"]["seconds"] = std::abs(number(random)) + 0.1;
        if (chance()) body["method"]["parameters"]["radius"] = std::abs(number(random)) / 20 + 0.01;
        if (chance()) body["layers"] = {"normal", "caustic"};
        if (chance()) body["priority"] = static_cast<int>(random() % 201) - 100;
        if (chance()) body["quiet_machine"] = static_cast<double>(random() % 1000) / 8;
        if (chance()) body["labels"]["k"] = std::to_string(random());
        if (chance()) body["environment"] = {{"image", "image:x"}, {"rotation", number(random)}};
        if (chance()) body["first_pass"] = random() % 1000;
        if (chance()) body["time"] = number(random);
        if (chance()) body["shutter"] = std::abs(number(random));
        if (chance()) body["animation"] = chance() ? json("walk") : json(random() % 4);
        if (chance()) {
            const json references[] = {
                "job:J17", "image:abc", {{"method", {{"name", "path_tracing"}}}, {"stop", {{"seconds", 2.5}}}}};
            body["reference"] = references[random() % 3];
            if (chance()) body["metrics"] = {"rmse", "direct:relative_mse"};
            if (chance()) body["stop"]["target"] = {{"metric", "beauty:rmse"}, {"value", std::abs(number(random))}};
        } else if (chance()) {
            body["stop"]["target"] = {{"metric", "estimated_relative_mse"}, {"value", 1e-3}};
        }
        const json echo = to_json(parse_job_request(body, vocabulary()));
        const json again = to_json(parse_job_request(json::parse(echo.dump()), vocabulary()));
        ASSERT_EQ(echo.dump(), again.dump());
    }
}

TEST(JobRequest, NamesAllFaultsAtOnce) {
    ErrorCode code{};
    const std::vector<std::string> pointers = pointers_of(json::parse(R"({
        "scen": "x", "camera": {"name": "a", "look_at": {"eye": [0, "x"], "target": [0, 0, 0], "roll": 1}},
        "image": {"width": 0, "height": 1.5}, "method": {"name": "path_tracing", "device": "gpu", "parameters": {"bounce": 1}},
        "stop": {"target": {"metric": "rmse", "value": 1}}, "layers": ["albdo", 3], "reference": "J1", "metrics": ["rsme", 1], "x/y": 1})"),
                                                          &code);
    EXPECT_EQ(code, ErrorCode::MissingField);
    EXPECT_EQ(pointers, (std::vector<std::string>{"/scene", "/camera/look_at/eye", "/camera/look_at/roll",
                                                  "/camera/look_at", "/image/width", "/image/height", "/method/device",
                                                  "/method/parameters/bounce", "/reference", "/layers/0", "/layers/1",
                                                  "/metrics/0", "/metrics/1", "/scen", "/x~1y"}));
}

TEST(JobRequest, SuggestsTheNearestName) {
    try {
        parse_job_request(with("/method/name", "\"path_traceing\""), vocabulary());
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(error.faults.at(0).detail.find("did you mean \"path_tracing\""), std::string::npos);
    }
}

TEST(JobRequest, RefusesEachFaultAtItsPlace) {
    const struct {
        const char* at;
        const char* value;
        const char* pointer;
        ErrorCode code;
    } cases[] = {
        {"/scene", "5", "/scene", ErrorCode::WrongType},
        {"/scene", "\"\"", "/scene", ErrorCode::OutOfRange},
        {"/scene", "null", "/scene", ErrorCode::MissingField},
        {"/image/width", "65537", "/image/width", ErrorCode::OutOfRange},
        {"/image/width", "-1", "/image/width", ErrorCode::OutOfRange},
        {"/image/width", "1e300", "/image/width", ErrorCode::OutOfRange},
        {"/image/width", "\"64\"", "/image/width", ErrorCode::WrongType},
        {"/image/filter", "\"bax\"", "/image/filter", ErrorCode::UnknownName},
        {"/method/device", "\"gpu:x\"", "/method/device", ErrorCode::UnknownName},
        {"/method/device", "\"gpu:0\"", "/method/device", ErrorCode::Unsupported},
        {"/method/parameters", "[]", "/method/parameters", ErrorCode::OutOfRange},
        {"/stop", "{}", "/stop", ErrorCode::MissingField},
        {"/stop", "{\"seconds\": null}", "/stop", ErrorCode::MissingField},
        {"/stop/passes", "0", "/stop/passes", ErrorCode::OutOfRange},
        {"/stop/seconds", "0", "/stop/seconds", ErrorCode::OutOfRange},
        {"/seed", "-1", "/seed", ErrorCode::OutOfRange},
        {"/seed", "1e30", "/seed", ErrorCode::OutOfRange},
        {"/seed", "0.5", "/seed", ErrorCode::OutOfRange},
        {"/seed", "\"1\"", "/seed", ErrorCode::WrongType},
        {"/layers", "{}", "/layers", ErrorCode::WrongType},
        {"/layers", "[\"depth\", \"depth\"]", "/layers/1", ErrorCode::Conflict},
        {"/layers", "[\"depth\", \"photon_count\"]", "/layers/1", ErrorCode::Unsupported},
        {"/priority", "101", "/priority", ErrorCode::OutOfRange},
        {"/quiet_machine", "-1", "/quiet_machine", ErrorCode::OutOfRange},
        {"/labels", "{\"a\": 1}", "/labels/a", ErrorCode::WrongType},
        {"/labels", "{\"a=b\": \"x\"}", "/labels/a=b", ErrorCode::OutOfRange},
        {"/environment", "{}", "/environment/image", ErrorCode::MissingField},
        {"/environment", "{\"image\": \"sky\"}", "/environment/image", ErrorCode::UnknownName},
        {"/glass", "\"hollow\"", "/glass", ErrorCode::UnknownName},
        {"/time", "1e10", "/time", ErrorCode::OutOfRange},
        {"/shutter", "-1", "/shutter", ErrorCode::OutOfRange},
        {"/animation", "-1", "/animation", ErrorCode::OutOfRange},
        {"/animation", "[0]", "/animation", ErrorCode::WrongType},
        {"/animation", "true", "/animation", ErrorCode::WrongType},
        {"/reference", "\"J1\"", "/reference", ErrorCode::UnknownName},
        {"/reference", "\"job:\"", "/reference", ErrorCode::UnknownName},
        {"/reference", "\"image:\"", "/reference", ErrorCode::UnknownName},
        {"/reference", "1", "/reference", ErrorCode::WrongType},
        {"/reference", "[]", "/reference", ErrorCode::WrongType},
        {"/reference", R"({"method": {"name": "path_tracing"}})", "/reference/stop", ErrorCode::MissingField},
        {"/reference", R"({"stop": {"passes": 1}})", "/reference/method", ErrorCode::MissingField},
        {"/reference", R"({"method": {"name": "x"}, "stop": {"passes": 1}})", "/reference/method/name",
         ErrorCode::UnknownName},
        {"/reference", R"({"method": {"name": "path_tracing"}, "stop": {}})", "/reference/stop",
         ErrorCode::MissingField},
        {"/reference", R"({"method": {"name": "path_tracing"}, "stop": {"passes": 1}, "seed": 2})", "/reference/seed",
         ErrorCode::UnknownField},
        {"/reference", R"({"method": {"name": "path_tracing"}, "stop": {"target": {"metric": "rmse", "value": 1}}})",
         "/reference/stop/target/metric", ErrorCode::Conflict},
        {"/stop/target", R"({"metric": "rmse", "value": 1})", "/stop/target/metric", ErrorCode::Conflict},
        {"/stop/target", R"({"metric": "estimated_relative_mse"})", "/stop/target/value", ErrorCode::MissingField},
        {"/stop/target", R"({"metric": "estimated_relative_mse", "value": -1})", "/stop/target/value",
         ErrorCode::OutOfRange},
        {"/metrics", "[\"rmse\"]", "/metrics", ErrorCode::Conflict},
        {"/metrics", "{}", "/metrics", ErrorCode::WrongType},
        {"/first_pass", "-1", "/first_pass", ErrorCode::OutOfRange},
        {"/first_pass", "0.5", "/first_pass", ErrorCode::WrongType},
        {"/camera", "{\"aperture\": 0.1}", "/camera/focus_distance", ErrorCode::MissingField},
        {"/camera", "{\"focus_distance\": 0}", "/camera/focus_distance", ErrorCode::OutOfRange},
        {"/camera", R"({"look_at": {"eye": [0,0,0], "target": [0,0,0]}})", "/camera/look_at/target",
         ErrorCode::Conflict},
        {"/camera", R"({"look_at": {"eye": [0,0,0], "target": [0,1,0]}})", "/camera/look_at/up", ErrorCode::Conflict},
        {"/camera", R"({"look_at": {"eye": [0,0,0], "target": [0,1,1], "up": [0,0,0]}})", "/camera/look_at/up",
         ErrorCode::Conflict},
        {"/camera", R"({"look_at": {"eye": [0,0,1e300], "target": [0,1,0]}})", "/camera/look_at/eye/2",
         ErrorCode::OutOfRange},
        {"/camera", R"({"look_at": {"eye": [0,0,1], "target": [0,1,0], "yfov": 3.15}})", "/camera/look_at/yfov",
         ErrorCode::OutOfRange},
    };
    for (const auto& wrong : cases) {
        ErrorCode code{};
        EXPECT_EQ(pointers_of(with(wrong.at, wrong.value), &code), std::vector<std::string>{wrong.pointer})
            << wrong.at << " = " << wrong.value;
        EXPECT_EQ(code, wrong.code) << wrong.at << " = " << wrong.value;
    }
}

TEST(JobRequest, MetricsAreOfLayersThatTheImageHolds) {
    json body = smallest();
    body["reference"] = "job:J1";
    body["metrics"] = {"rmse", "albedo:rmse", "caustic:rmse", "indirect:rmse", "rmse"};
    body["stop"]["target"] = {{"metric", "caustic:relative_mse"}, {"value", 1}};
    EXPECT_EQ(pointers_of(body), (std::vector<std::string>{"/metrics/1", "/metrics/4", "/stop/target/metric",
                                                           "/metrics/1", "/metrics/2"}));
    body["metrics"] = {"rmse", "caustic:rmse", "indirect:rmse"};
    body["layers"] = {"caustic"};
    EXPECT_EQ(parse_job_request(body, vocabulary()).metrics.size(), 3u);
}

TEST(JobRequest, AStopIsReadByItself) {
    BodyFaults faults;
    const json target{{"metric", "relative_mse"}, {"value", 0.5}};
    const StopConditions stop = read_stop_conditions({{"target", target}}, "/stop", vocabulary(), true, faults);
    EXPECT_EQ(faults.size(), 0u);
    EXPECT_EQ(to_json(stop), (json{{"seconds", nullptr}, {"passes", nullptr}, {"target", target}}));
    read_stop_conditions({{"target", target}}, "/stop", vocabulary(), false, faults);
    EXPECT_EQ(faults.size(), 1u);
}

TEST(JobRequest, AMethodMayHaveLayersThatOthersLack) {
    json body = smallest();
    body["layers"] = {"photon_count"};
    try {
        parse_job_request(body, vocabulary());
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(error.faults.at(0).detail.find("path_tracing has no layer \"photon_count\""), std::string::npos);
    }
    body["method"]["name"] = "photon_mapping";
    EXPECT_EQ(parse_job_request(body, vocabulary()).layers, std::vector<std::string>{"photon_count"});
    body["method"]["name"] = "photon_maping";  // then nobody can know
    EXPECT_EQ(pointers_of(body), std::vector<std::string>{"/method/name"});
}

TEST(JobRequest, RefusesWhatIsNoObject) {
    for (const char* body : {"null", "1", "[]", "\"x\""})
        EXPECT_EQ(pointers_of(json::parse(body)), std::vector<std::string>{""}) << body;
}

TEST(JobRequest, AnswersOfBoundedSize) {
    json body = smallest();
    for (int i = 0; i < 5000; ++i) body["field" + std::to_string(i)] = i;
    try {
        parse_job_request(body, vocabulary());
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.faults.size(), 256u);
        EXPECT_NE(std::string(error.what()).find("5000 faults"), std::string::npos) << error.what();
    }
}

// A job that asks for nothing new has the name that it had before there was anything to ask for.
TEST(JobRequest, NewParametersThatAreOffHaveNoPartInTheName) {
    const json before = {{"method", {{"parameters", {{"cells", 512}}}}}};
    json now = before;
    now["method"]["parameters"].update({{"aged", false}, {"cache_age", 8}, {"temporal", "none"}, {"history_cap", 16}});
    EXPECT_EQ(naming_json(now), before);
    now["method"]["parameters"]["aged"] = true;
    EXPECT_NE(naming_json(now), before);
    json keeps_lists = before;
    keeps_lists["method"]["parameters"]["kept_lists"] = 0;
    EXPECT_EQ(naming_json(keeps_lists), before);
    keeps_lists["method"]["parameters"]["kept_lists"] = 1;
    EXPECT_NE(naming_json(keeps_lists), before);
}

TEST(JobRequest, NewParametersOfSomeMethodsKeepTheirPartInTheNamesOfOthers) {
    const auto named = [](const json& parameters) { return naming_json({{"method", {{"parameters", parameters}}}}); };
    const json lights = {{"visibility", "svo"}, {"placement", "flux"}, {"clamp", nullptr}}, points = {{"points", 64}};
    EXPECT_EQ(named(lights)["method"]["parameters"], lights);
    const auto with = [](json parameters, const char* key, const json& value) {
        parameters[key] = value;
        return parameters;
    };
    EXPECT_EQ(named(with(lights, "near_field_radius", nullptr)), named(lights));
    EXPECT_NE(named(with(lights, "near_field_radius", 0.0)), named(lights));
    EXPECT_EQ(named(with(points, "placement", "flux")), named(points));
    EXPECT_NE(named(with(points, "placement", "acceptance")), named(points));
}

}  // namespace
}  // namespace photond::job_request_test
