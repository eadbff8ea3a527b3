#include "clients/cli/parameter_schema.h"

#include <algorithm>
#include <charconv>

#include "clients/cli/failure.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

std::string joined(const std::vector<std::string>& words, const char* separator) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
    return text;
}

bool has_type(const json& schema, const char* type) {
    if (!schema.contains("type")) return false;
    const json& types = schema["type"];
    return types.is_array() ? std::find(types.begin(), types.end(), type) != types.end() : types == type;
}

/// The whole of `text` as a number of type T, nothing before or after it.
template <class T>
std::optional<T> whole_number(const std::string& text) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace

std::string Parameter::option_name() const {
    std::string option = "--" + name;
    std::replace(option.begin(), option.end(), '_', '-');
    return option;
}

std::string Parameter::value_name() const {
    if (!words.empty()) return joined(words, "|");
    if (is_boolean) return "true|false";
    if (is_integer) return "INT";
    return is_number ? "NUMBER" : "TEXT";
}

std::string Parameter::range_text() const {
    if (!words.empty()) return joined(words, ", ");
    if (is_boolean) return "true, false";
    if (minimum && maximum) return human_number(*minimum) + " to " + human_number(*maximum);
    if (minimum) return "at least " + human_number(*minimum);
    if (maximum) return "at most " + human_number(*maximum);
    return "";
}

std::string Parameter::help() const {
    std::string help = text;
    if (!unit.empty()) help += " [" + unit + "]";
    if (words.empty() && !is_boolean && !range_text().empty()) help += ", " + range_text();
    return help + (default_value.is_null() ? "; default: none" : "; default: " + plain_text(default_value));
}

json Parameter::parse(const std::string& value) const {
    const auto fail = [&](const std::string& what) {
        return Failure(ExitCode::Usage, name + " = " + printable(value) + " " + what, help());
    };
    if (is_nullable && value == "none") return nullptr;
    if (!words.empty()) {
        if (std::find(words.begin(), words.end(), value) == words.end())
            throw fail("is none of " + joined(words, ", "));
        return value;
    }
    if (is_boolean) {
        if (value == "true") return true;
        if (value == "false") return false;
        throw fail("is neither true nor false");
    }
    if (!is_number) return value;

    json number;
    if (const auto whole = whole_number<int64_t>(value))
        number = *whole;
    else if (is_integer)
        throw fail("is not a whole number");
    else if (const auto real = whole_number<double>(value))
        number = *real;
    else
        throw fail("is not a number");
    const double x = number.get<double>();
    const bool inside = (!minimum || x >= *minimum) && (!maximum || x <= *maximum) && x == x;
    if (!inside) throw fail("is outside " + range_text());
    return number;
}

std::vector<Parameter> parameters_of(const json& method) {
    std::vector<Parameter> parameters;
    const json schema = method.value("parameters", json::object());
    const json properties = schema.value("properties", json::object());
    for (const auto& [name, property] : properties.items()) {
        Parameter parameter;
        parameter.name = name;
        parameter.is_boolean = has_type(property, "boolean");
        parameter.is_integer = has_type(property, "integer");
        parameter.is_number = parameter.is_integer || has_type(property, "number");
        parameter.is_nullable = has_type(property, "null");
        if (property.contains("enum"))
            for (const json& word : property["enum"])
                if (word.is_string()) parameter.words.push_back(word.get<std::string>());
        if (property.contains("minimum")) parameter.minimum = property["minimum"].get<double>();
        if (property.contains("maximum")) parameter.maximum = property["maximum"].get<double>();
        parameter.default_value = property.value("default", json());
        parameter.unit = property.value("x-unit", "");
        parameter.text = printable(property.value("description", ""));
        parameters.push_back(std::move(parameter));
    }
    const json order = schema.value("x-order", json::array());
    const auto place = [&order](const Parameter& parameter) {
        return std::find(order.begin(), order.end(), parameter.name) - order.begin();
    };
    std::stable_sort(parameters.begin(), parameters.end(),
                     [&](const Parameter& a, const Parameter& b) { return place(a) < place(b); });
    return parameters;
}

}  // namespace photond::cli
