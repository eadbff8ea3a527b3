// Requests of before, which lack parameters that are new, are given what stands for them, once.

#include "server/service/older_requests.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "protocol/param_json.h"
#include "renderer/methods/registry.h"
#include "server/job_vocabulary.h"
#include "server/service/references.h"

namespace photond::older_requests_test {
namespace {

using nlohmann::json;

json method(const std::string& name, json parameters = json::object()) {
    return {{"name", name}, {"device", "cpu"}, {"parameters", std::move(parameters)}};
}

json job_request(json of_method, json reference = nullptr) {
    return {{"scene", "box"},
            {"image", {{"width", 8}, {"height", 8}}},
            {"stop", {{"passes", 1}}},
            {"method", std::move(of_method)},
            {"reference", std::move(reference)}};
}

TEST(OlderRequests, WhatAMethodSaysOfBeforeAreParametersOfIt) {
    size_t settings = 0;
    for (const MethodInfo& info : all_methods()) {
        json request = job_request(method(std::string(info.name)));
        const bool completed = complete_request(request);  // throws for what is no parameter, or no value of it
        const json parameters = request["method"]["parameters"], now = params_to_json(*info.make_params());
        EXPECT_EQ(completed, !now.empty()) << info.name;
        EXPECT_EQ(parameters.size(), now.size()) << info.name;
        size_t others = 0;
        for (const auto& [name, value] : now.items()) others += parameters.at(name) != value;
        EXPECT_LE(others, info.settings_before.size()) << info.name;
        settings += info.settings_before.size();
        EXPECT_FALSE(complete_request(request)) << "it lacks nothing now";
    }
    EXPECT_GE(settings, 4u);
}

TEST(OlderRequests, WhatIsLackingIsAddedAndWhatIsThereStays) {
    json request = job_request(method("photon_mapping", {{"photons", 500}}),
                               {{"method", method("svo_many_lights", {{"bounces", 3}})}, {"stop", {{"passes", 2}}}});
    EXPECT_TRUE(complete_request(request));
    EXPECT_EQ(request["method"]["parameters"]["photons"], 500);
    EXPECT_EQ(request["method"]["parameters"]["boundary"], "none");
    EXPECT_EQ(request["reference"]["method"]["parameters"]["bounces"], 3);
    EXPECT_EQ(request["reference"]["method"]["parameters"]["caustic_photons"], 0);

    json comparison{{"entries",
                     {{{"method", method("photon_splatting")}, {"sweep", json::object()}},
                      {{"method", method("photon_mapping", {{"boundary", "clip"}})}}}},
                    {"reference", "job:J3"}};
    EXPECT_TRUE(complete_request(comparison));
    EXPECT_EQ(comparison["entries"][0]["method"]["parameters"]["bounces"], 1);
    EXPECT_EQ(comparison["entries"][1]["method"]["parameters"]["boundary"], "clip");
    EXPECT_EQ(comparison["reference"], "job:J3");

    for (json strange : {json(), json::array(), json::object(), json{{"method", method("unheard_of")}}}) {
        const json was = strange;
        EXPECT_FALSE(complete_request(strange));
        EXPECT_EQ(strange, was);
    }
}

struct TemporaryFolder {
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "photond-requests-XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
    std::filesystem::path path;
};

JobRow row_of(const json& request, const std::string& content = "") {
    JobRow row;
    row.device = "cpu";
    row.method = request["method"]["name"];
    row.scene = "0123";
    row.request = request.dump();
    row.content = content;
    if (!content.empty()) row.role = JobRole::Reference;
    return row;
}

TEST(OlderRequests, AStoreIsCompletedOnceAndReferencesAreFoundByWhatTheyShow) {
    const TemporaryFolder folder;
    Store store(folder.path / "store");
    const JobVocabulary vocabulary = job_vocabulary();
    const json film = job_request(method("photon_mapping", {{"photons", 500}}));
    JobRow job = row_of(job_request(method("photon_splatting", {{"photons", 7}})));
    JobRow reference = row_of(film, "one of two films: of a request without what is new");
    JobRow other = row_of(film, "of before there were two");
    ComparisonRow comparison;
    comparison.scene = "0123";
    comparison.request = json{{"entries", {{{"method", method("svo_many_lights")}}}}}.dump();
    {
        auto transaction = store.transaction();
        for (JobRow* row : {&job, &reference, &other}) store.insert_job(*row);
        store.insert_comparison(comparison);
        transaction.commit();
    }
    complete_requests(store, vocabulary);
    EXPECT_EQ(json::parse(store.job(job.seq)->request)["method"]["parameters"]["bounces"], 1);
    EXPECT_EQ(json::parse(store.job(job.seq)->request)["method"]["parameters"]["photons"], 7);
    EXPECT_EQ(store.job(job.seq)->content, "");
    EXPECT_EQ(
        json::parse(store.comparison(comparison.seq)->request)["entries"][0]["method"]["parameters"]["caustic_photons"],
        0);
    json explicitly = film;
    explicitly["method"]["parameters"].update({{"boundary", "none"}, {"precompute_irradiance", false}});
    EXPECT_EQ(store.job(reference.seq)->content,
              References::reference_content(parse_job_request(explicitly, vocabulary), "0123"));
    EXPECT_EQ(store.job(other.seq)->content, "of before there were two");

    // It is done: what comes later is whole, and is not looked at.
    {
        auto transaction = store.transaction();
        job.request = R"({"method":{"name":"photon_splatting","parameters":{}}})";
        store.update_job(job);
        transaction.commit();
    }
    complete_requests(store, vocabulary);
    EXPECT_EQ(store.job(job.seq)->request, job.request);
    {
        auto transaction = store.transaction();
        store.set_requests_are_of("other parameters");
        transaction.commit();
    }
    complete_requests(store, vocabulary);
    EXPECT_NE(store.job(job.seq)->request, job.request);
}

}  // namespace
}  // namespace photond::older_requests_test
