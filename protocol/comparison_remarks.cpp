#include "protocol/comparison_remarks.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace photond {

namespace {

/// What is wrong with the text; empty where nothing is.
std::string fault_of(const std::string& text, size_t most_bytes, std::string_view permitted) {
    if (text.empty() || text.size() > most_bytes)
        return "must have 1 to " + std::to_string(most_bytes) + " bytes, or be null; has " +
               std::to_string(text.size());
    const bool is_plain = std::all_of(text.begin(), text.end(), [&](char c) {
        return (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) || permitted.find(c) != std::string_view::npos;
    });
    return is_plain ? "" : "must not contain control characters";
}

}  // namespace

nlohmann::json read_remarks(const nlohmann::json& body, ObjectReader& reader, BodyFaults& faults) {
    nlohmann::json remarks = nlohmann::json::object();
    const auto read = [&](const char* key, size_t most_bytes, std::string_view permitted) {
        const nlohmann::json* value = reader.member(key);
        if (value == nullptr) {
            if (body.contains(key)) remarks[key] = nullptr;
            return;
        }
        const std::string pointer = std::string("/") + key;
        if (!value->is_string()) {
            faults.add(ErrorCode::WrongType, pointer, "must be a string or null");
            return;
        }
        if (std::string fault = fault_of(value->get<std::string>(), most_bytes, permitted); !fault.empty())
            faults.add(ErrorCode::OutOfRange, pointer, std::move(fault));
        remarks[key] = *value;
    };
    read("title", kMaxTitleBytes, "");
    read("notes", kMaxNotesBytes, "\n\t");
    return remarks;
}

}  // namespace photond
