// What the rows say of their methods holds: settings that exist, hard cases that exist, texts for those who read them.

#include "renderer/methods/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "renderer/scene/hard_cases.h"

namespace photond::registry_test {
namespace {

/// The words of each parameter that has some.
class WordsOf final : public ParamVisitor {
public:
    explicit WordsOf(const MethodInfo& method) { method.make_params()->visit(*this); }
    bool has(const ParamSetting& setting) const {
        const auto found = words_.find(setting.name);
        return found != words_.end() &&
               std::find(found->second.begin(), found->second.end(), setting.word) != found->second.end();
    }

    void field(std::string_view, float&, const ParamInfo&) override {}
    void field(std::string_view, uint32_t&, const ParamInfo&) override {}
    void field(std::string_view, std::optional<float>&, const ParamInfo&) override {}
    void field(std::string_view, std::optional<uint32_t>&, const ParamInfo&) override {}
    void flag(std::string_view, bool&, const ParamFlag&) override {}
    void choice(std::string_view key, uint32_t&, const ParamChoice& choice) override { words_[key] = choice.words; }

private:
    std::map<std::string_view, std::span<const std::string_view>> words_;
};

bool is_part_of_a_row(std::string_view text) {
    return std::any_of(hard_cases().begin(), hard_cases().end(),
                       [&](const HardCase& hard_case) { return hard_case.answer.row.find(text) != std::string::npos; });
}

TEST(Registry, MethodsAreInTheOrderOfTheirNames) {
    const auto methods = all_methods();
    ASSERT_FALSE(methods.empty());
    EXPECT_TRUE(std::is_sorted(methods.begin(), methods.end(),
                               [](const MethodInfo& a, const MethodInfo& b) { return a.name < b.name; }));
    for (const MethodInfo& method : methods) EXPECT_EQ(find_method(method.name), &method);
    EXPECT_EQ(find_method("no_such_method"), nullptr);
}

TEST(Registry, EveryRowSaysWhatItsMethodIs) {
    for (const MethodInfo& method : all_methods()) {
        SCOPED_TRACE(method.name);
        EXPECT_FALSE(method.title.empty() || method.line.empty() || method.family.empty() || method.sources.empty());
        EXPECT_FALSE(method.devices().empty());
        EXPECT_EQ(method.make != nullptr, method.estimate_bytes != nullptr);
        EXPECT_EQ(method.make_gpu != nullptr, method.estimate_bytes_gpu && method.estimate_device_bytes);
        for (const Source& source : method.sources) EXPECT_FALSE(source.author.empty() || source.title.empty());
    }
    EXPECT_EQ(find_method("path_tracing")->sources.front().text(), "Kajiya 1986, The Rendering Equation");
}

TEST(Registry, VariantsAndLimitsNameSettingsThatThereAre) {
    for (const MethodInfo& method : all_methods()) {
        SCOPED_TRACE(method.name);
        const WordsOf words(method);
        for (const MethodVariant& variant : method.variants) {
            EXPECT_FALSE(variant.label.empty() || variant.settings.empty());
            for (const ParamSetting& setting : variant.settings) EXPECT_TRUE(words.has(setting)) << setting.name;
        }
        for (const KnownLimit& limit : method.limits)
            for (const ParamSetting& setting : limit.settings) EXPECT_TRUE(words.has(setting)) << setting.name;
    }
}

TEST(Registry, LimitsAndRefusalsNameHardCasesThatThereAre) {
    for (const MethodInfo& method : all_methods()) {
        for (const CaseRefusal& refusal : method.refusals) {
            EXPECT_FALSE(refusal.row.empty() || refusal.text.empty());
            EXPECT_TRUE(is_part_of_a_row(refusal.row)) << method.name << ": " << refusal.row;
        }
        for (const KnownLimit& limit : method.limits) {
            EXPECT_FALSE(limit.text.empty());
            EXPECT_TRUE(is_part_of_a_row(limit.row)) << method.name << ": " << limit.row;
        }
    }
}

}  // namespace
}  // namespace photond::registry_test
