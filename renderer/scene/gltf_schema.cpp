#include "renderer/scene/gltf_schema.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace photond {

namespace {

using schema::Kind;

[[noreturn]] void fail_type(const Json& value, const std::string& wanted) {
    fail(value, "must be " + wanted + ", not " + shown(value));
}

double judged_number(const Json& value, const JsonType& type) {
    if (!value.is_number()) fail_type(value, "a number");
    const auto x = value.get<double>();
    if (!(x >= type.min && x <= type.max))
        fail(value, shown(value) + " is outside [" + shown(type.min) + ", " + shown(type.max) + "]");
    if (!(static_cast<float>(x) > static_cast<float>(type.above)))
        fail(value, "must be greater than " + shown(type.above));
    return x;
}

uint64_t judged_whole(const Json& value, double min, double max) {
    const double x = value.is_number() ? value.get<double>() : NAN;
    constexpr double kExact = 9007199254740992.0;  // beyond 2^53 a double no longer tells whole numbers apart
    if (!(std::fabs(x) <= kExact) || x != std::floor(x)) fail_type(value, "a whole number");
    if (x < min || x > max)
        fail(value, shown(value) + " is outside [" + std::to_string(static_cast<uint64_t>(min)) + ", " +
                        std::to_string(static_cast<uint64_t>(max)) + "]");
    return static_cast<uint64_t>(x);
}

/// The array of the root by that name ("lights": of KHR_lights_punctual), or null.
const Json* find_array(const Json& root, std::string_view name) {
    if (name != "lights") return find_member(root, name);
    const Json* extension = find_extension(root, "KHR_lights_punctual");
    return extension == nullptr ? nullptr : find_member(*extension, name);
}

uint64_t judged_index(const Json& root, const Json& value, std::string_view array) {
    const Json* counted = find_array(root, array);
    // The nodes are judged after the joints that name them.
    if (array == "nodes" && counted != nullptr && !counted->is_array()) fail_type(*counted, "an array");
    const size_t count = counted != nullptr && counted->is_array() ? counted->size() : 0;
    if (value.is_number() && value.get<double>() >= static_cast<double>(count))
        fail(value, shown(value) + " is not an index into the " + std::to_string(count) + " " + std::string(array));
    return judged_whole(value, 0, count == 0 ? 0 : static_cast<double>(count - 1));
}

void judge_one_of(Json& value, std::string_view words) {
    const bool numeric = words.front() >= '0' && words.front() <= '9';
    if (numeric) value = judged_whole(value, 0, 65535);
    if (!numeric && !value.is_string()) fail_type(value, "a string");
    const std::string word = numeric ? value.dump() : value.get<std::string>();
    const std::string all = '|' + std::string(words) + '|';
    if (word.find('|') == std::string::npos && all.find('|' + word + '|') != std::string::npos) return;
    fail(value, shown(value) + " is none of " + std::string(words));
}

/// Judges parts of one tree.
class Judge {
public:
    explicit Judge(Json& root) : root_(root) {}

    FaultList faults;

    /// Runs a step and keeps the fault it may find; true when it found none. Does nothing when there are faults enough.
    template <class Step>
    bool collect(const Step& step) {
        if (faults.size() >= FaultList::kMaxFaults) return false;
        try {
            step();
            return true;
        } catch (const JsonFault& fault) {
            faults.add(fault, root_);
            return false;
        }
    }

    void judge_members(Json& object, std::span<const JsonMember> members) {
        if (!object.is_object()) fail_type(object, "an object");
        for (const JsonMember& member : members) {
            const bool chosen = member.chosen && object["type"] == member.key;
            Json* place = member.extension ? find_member(object, "extensions") : &object;
            Json* found = place == nullptr ? nullptr : find_member(*place, member.key);
            if (member.chosen && !chosen)
                object.erase(std::string(member.key));
            else if (member.absent && (found == nullptr || member.type.kind == Kind::Any))
                object[std::string(member.key)] = *member.absent;
            else if (found != nullptr)
                judge(*found, member.type);
            else if (member.required || chosen)
                throw JsonFault{&object, std::string(member.key), '"' + std::string(member.key) + "\" is missing",
                                ErrorCode::BadScene};
        }
    }

private:
    void judge(Json& value, const JsonType& type) {
        const size_t faults_before = faults.size();
        switch (type.kind) {
            case Kind::Text:
                if (!value.is_string()) fail_type(value, "a string");
                break;
            case Kind::Boolean:
                if (!value.is_boolean()) fail_type(value, "true or false");
                break;
            case Kind::Number: value = judged_number(value, type); break;
            case Kind::Whole: value = judged_whole(value, type.min, type.max); break;
            case Kind::Index: value = judged_index(root_, value, type.words); break;
            case Kind::OneOf: judge_one_of(value, type.words); break;
            case Kind::Array:
                judge_elements(value, type);
                if (faults.size() != faults_before) return;
                break;
            case Kind::Map:
                if (!value.is_object()) fail_type(value, "an object");
                for (Json& element : value) judge(element, *type.element);
                break;
            case Kind::Object:
                judge_members(value, type.members);
                keep_members(value, type.members);
                break;
            case Kind::Any: break;
        }
        if (type.rule != nullptr) type.rule(root_, value);
    }

    void judge_elements(Json& array, const JsonType& type) {
        if (!array.is_array()) fail_type(array, "an array");
        if (array.size() < type.min_size || array.size() > type.max_size)
            fail(array, "has " + std::to_string(array.size()) + " elements, " +
                            (type.max_size == type.min_size ? "not " : "fewer than ") + std::to_string(type.min_size));
        const JsonType element_type =
            type.element != nullptr ? *type.element : schema::object(type.members, type.element_rule);
        for (Json& element : array) {
            if (!type.gathered)
                judge(element, element_type);
            else if (!collect([&] { judge(element, element_type); }))
                element = Json::object();  // what comes after looks at nothing that has not been judged
        }
    }

    Json& root_;
};

}  // namespace

void judge_layer(Json& root, std::span<const JsonMember> members) {
    Judge judge(root);
    for (const JsonMember& member : members) judge.collect([&] { judge.judge_members(root, {&member, 1}); });
    judge.faults.throw_if_any();
}

void keep_members(Json& object, std::span<const JsonMember> members, bool extensions) {
    auto& all = object.get_ref<Json::object_t&>();
    const auto named = [&](auto& member) {
        const bool inner = !extensions && member.first == "extensions" && member.second.is_object();
        if (inner) keep_members(member.second, members, true);
        return inner || std::ranges::any_of(members, [&](const JsonMember& each) {
                   return each.key == member.first && each.extension == extensions;
               });
    };
    if (std::ranges::all_of(all, named)) return;
    Json kept = Json::object();
    for (auto& member : all)
        if (named(member)) kept.get_ref<Json::object_t&>().emplace_back(member.first, std::move(member.second));
    object = std::move(kept);
}

}  // namespace photond
