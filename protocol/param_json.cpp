#include "protocol/param_json.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "protocol/nearest_name.h"
#include "protocol/strict_json.h"

namespace photond {
namespace {

using nlohmann::json;

// JSON knows one kind of number: 5.0 is as whole as 5, and JSON Schema says so too.
bool is_whole(const json& value) {
    if (value.is_number_integer()) return true;
    return value.is_number_float() && std::nearbyint(value.get<double>()) == value.get<double>();
}

std::string range_text(const ParamInfo& info) {
    return std::string("[").append(number_text(info.min)) + ", " + number_text(info.max) + "]" +
           (info.unit.empty() ? "" : " " + std::string(info.unit));
}

class Reader final : public ParamVisitor {
public:
    Reader(const json& source, const std::string& pointer, std::vector<Fault>& faults)
        : source_(source), pointer_(pointer), faults_(faults) {}

    void field(std::string_view key, float& value, const ParamInfo& info) override { number(key, value, info); }
    void field(std::string_view key, uint32_t& value, const ParamInfo& info) override { number(key, value, info); }
    void field(std::string_view key, std::optional<float>& value, const ParamInfo& info) override {
        optional_number(key, value, info);
    }
    void field(std::string_view key, std::optional<uint32_t>& value, const ParamInfo& info) override {
        optional_number(key, value, info);
    }
    void flag(std::string_view key, bool& value, const ParamFlag&) override {
        const json* given = find(key);
        if (given == nullptr) return;
        if (!given->is_boolean())
            return fault(ErrorCode::WrongType, key, "must be true or false, got " + value_text(*given));
        value = given->get<bool>();
    }
    void choice(std::string_view key, uint32_t& value, const ParamChoice& choices) override {
        const json* given = find(key);
        if (given == nullptr) return;
        std::vector<std::string> words(choices.words.begin(), choices.words.end());
        std::string list;
        for (const std::string& word : words) list += (list.empty() ? "\"" : ", \"") + word + "\"";
        if (!given->is_string())
            return fault(ErrorCode::WrongType, key, "must be one of " + list + ", got " + value_text(*given));
        const auto word = given->get<std::string>();
        for (size_t i = 0; i < words.size(); ++i)
            if (words[i] == word) {
                value = static_cast<uint32_t>(i);
                return;
            }
        fault(ErrorCode::UnknownName, key,
              "must be one of " + list + ", got " + value_text(*given) + did_you_mean(word, words));
    }

    void refuse_unknown() {
        for (const auto& [key, value] : source_.items()) {
            bool known = false;
            for (const std::string& name : known_) known = known || name == key;
            if (!known) fault(ErrorCode::UnknownField, key, "unknown parameter" + did_you_mean(key, known_));
        }
    }

private:
    const json* find(std::string_view key) {
        known_.emplace_back(key);
        const auto found = source_.find(std::string(key));
        return found == source_.end() ? nullptr : &*found;
    }

    template <class Value>
    void optional_number(std::string_view key, std::optional<Value>& value, const ParamInfo& info) {
        const auto found = source_.find(std::string(key));
        if (found != source_.end() && found->is_null()) {
            known_.emplace_back(key);
            value.reset();
            return;
        }
        Value read = value.value_or(Value{});
        if (number(key, read, info)) value = read;
    }

    template <class Value>
    bool number(std::string_view key, Value& value, const ParamInfo& info) {
        const json* given = find(key);
        if (given == nullptr) return false;
        constexpr bool kWhole = std::is_integral_v<Value>;
        if (!given->is_number() || (kWhole && !is_whole(*given))) {
            fault(ErrorCode::WrongType, key,
                  std::string(kWhole ? "must be a whole number" : "must be a number") + ", got " + value_text(*given));
            return false;
        }
        const double x = given->get<double>();
        if (!(x >= info.min && x <= info.max)) {  // written so that NaN fails too
            fault(ErrorCode::OutOfRange, key, value_text(*given) + " is outside " + range_text(info));
            return false;
        }
        // Declared ranges are doubles: one that is wider than the field's own type is held to the type.
        if (!(std::abs(x) <= static_cast<double>(std::numeric_limits<Value>::max()))) {
            fault(ErrorCode::OutOfRange, key, value_text(*given) + " is too large");
            return false;
        }
        value = static_cast<Value>(x);
        return true;
    }

    void fault(ErrorCode code, std::string_view key, const std::string& detail) {
        faults_.emplace_back(code, pointer_ + "/" + pointer_token(key), std::string(key) + ": " + detail);
    }

    const json& source_;
    const std::string& pointer_;
    std::vector<Fault>& faults_;
    std::vector<std::string> known_;
};

class Writer final : public ParamVisitor {
public:
    void field(std::string_view key, float& value, const ParamInfo&) override { put(key, shortest_double(value)); }
    void field(std::string_view key, uint32_t& value, const ParamInfo&) override { put(key, value); }
    void field(std::string_view key, std::optional<float>& value, const ParamInfo&) override {
        put(key, value ? json(shortest_double(*value)) : json(nullptr));
    }
    void field(std::string_view key, std::optional<uint32_t>& value, const ParamInfo&) override {
        put(key, value ? json(*value) : json(nullptr));
    }
    void flag(std::string_view key, bool& value, const ParamFlag&) override { put(key, value); }
    void choice(std::string_view key, uint32_t& value, const ParamChoice& choices) override {
        put(key, choices.words[value]);
    }
    json take() { return std::move(object_); }

private:
    template <class Value>
    void put(std::string_view key, Value&& value) {
        object_[std::string(key)] = std::forward<Value>(value);
    }
    json object_ = json::object();
};

class SchemaWriter final : public ParamVisitor {
public:
    void field(std::string_view key, float& value, const ParamInfo& info) override {
        number(key, "number", shortest_double(value), info);
    }
    void field(std::string_view key, uint32_t& value, const ParamInfo& info) override {
        number(key, "integer", value, info);
    }
    void field(std::string_view key, std::optional<float>& value, const ParamInfo& info) override {
        number(key, {"number", "null"}, value ? json(shortest_double(*value)) : json(nullptr), info);
    }
    void field(std::string_view key, std::optional<uint32_t>& value, const ParamInfo& info) override {
        number(key, {"integer", "null"}, value ? json(*value) : json(nullptr), info);
    }
    void flag(std::string_view key, bool& value, const ParamFlag& info) override {
        put(key, info.group, {{"type", "boolean"}, {"default", value}, {"description", info.text}, {"x-unit", ""}});
    }
    void choice(std::string_view key, uint32_t& value, const ParamChoice& choices) override {
        json words = json::array();
        for (const std::string_view word : choices.words) words.push_back(word);
        put(key, choices.group,
            {{"type", "string"},
             {"enum", words},
             {"default", choices.words[value]},
             {"description", choices.text},
             {"x-unit", ""}});
    }
    json take() {
        json groups = json::array();
        for (size_t i = 0; i < kParamGroupTitles.size(); ++i)
            if (used_groups_[i]) groups.push_back(kParamGroupTitles[i]);
        return {{"type", "object"},
                {"properties", properties_},
                {"additionalProperties", false},
                {"x-order", order_},
                {"x-groups", groups}};
    }

private:
    void number(std::string_view key, json type, json value, const ParamInfo& info) {
        const bool whole = type.dump().find("integer") != std::string::npos;
        const auto bound = [whole](double x) {
            return whole && std::abs(x) < 9e15 ? json(static_cast<int64_t>(x)) : json(x);
        };
        put(key, info.group,
            {{"type", std::move(type)},
             {"default", std::move(value)},
             {"minimum", bound(info.min)},
             {"maximum", bound(info.max)},
             {"description", info.text},
             {"x-unit", info.unit}});
    }
    void put(std::string_view key, ParamGroup group, json schema) {
        const auto index = static_cast<size_t>(group);
        used_groups_[index] = true;
        schema["x-group"] = kParamGroupTitles[index];
        properties_[std::string(key)] = std::move(schema);
        order_.push_back(key);
    }
    json properties_ = json::object();
    json order_ = json::array();  // as declared: the order of forms and help
    std::array<bool, kParamGroupTitles.size()> used_groups_{};
};

}  // namespace

void read_params(MethodParams& params, const json& source, const std::string& pointer, std::vector<Fault>& faults) {
    if (!source.is_object()) {
        faults.emplace_back(ErrorCode::WrongType, pointer, "must be an object, got " + value_text(source));
        return;
    }
    const size_t faults_before = faults.size();
    Reader reader(source, pointer, faults);
    params.visit(reader);
    reader.refuse_unknown();
    if (faults.size() != faults_before) return;
    try {
        params.check();
    } catch (const Error& error) {
        if (error.faults.empty()) faults.emplace_back(error.code, pointer, error.what());
        for (const Fault& fault : error.faults) faults.emplace_back(fault.code, pointer + fault.pointer, fault.detail);
    }
}

json params_to_json(MethodParams& params) {
    Writer writer;
    params.visit(writer);
    return writer.take();
}

json params_schema(MethodParams& defaults) {
    SchemaWriter writer;
    defaults.visit(writer);
    return writer.take();
}

double shortest_double(float value) {
    std::array<char, 64> text{};
    const auto written = std::to_chars(text.data(), text.data() + text.size(), value);
    double result = 0;
    std::from_chars(text.data(), written.ptr, result);
    return result;
}

std::string number_text(double value) {
    std::array<char, 64> text{};
    const auto written = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), written.ptr};
}

std::string value_text(const json& value) {
    if (value.is_object()) return "an object";
    if (value.is_array()) return "an array";
    if (value.is_number_float()) return number_text(value.get<double>());
    std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
    if (text.size() > 64) text = text.substr(0, 60) + " ...";
    return text;
}

std::string did_you_mean(const std::string& wrong, const std::vector<std::string>& known) {
    const std::string nearest = nearest_name(wrong, known);
    return nearest.empty() ? "" : " (did you mean \"" + nearest + "\"?)";
}

}  // namespace photond
