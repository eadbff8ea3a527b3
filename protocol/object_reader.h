#pragma once
// Strict reading of one JSON object: every fault is noted with its pointer and reading goes on, so that a client learns
// of all of them at once.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace photond {

/// All faults of one body, and the code of the first.
class BodyFaults {
public:
    void add(ErrorCode code, std::string pointer, std::string detail);
    /// Notes what somebody else found. Where the first of all faults is among them, the Error is one of `code`.
    void take(ErrorCode code, std::vector<Fault>&& faults);
    /// Throws them as one Error where there are any.
    void throw_if_any() const;
    size_t size() const { return faults_.size() + left_out_; }

private:
    static constexpr size_t kMostListed = 256;  // an answer of bounded size, however wrong the body
    std::vector<Fault> faults_;
    size_t left_out_ = 0;
    ErrorCode first_ = ErrorCode::Internal;
};

struct NumberRange {
    double min;
    double max;
    const char* unit = "";
};

/// Reads members one by one; finish() then refuses every key that nobody asked for. null is as good as absent
/// everywhere, since the echo of a request writes null where something does not apply.
class ObjectReader {
public:
    /// `source` may be of any type: what is no object is noted as a fault and read as an empty one.
    ObjectReader(const nlohmann::json& source, std::string pointer, BodyFaults& faults);

    /// The member, or nullptr where it is absent or null; `required` notes the fault.
    const nlohmann::json* member(const std::string& key, bool required = false);
    std::optional<std::string> string(const std::string& key, size_t max_length, bool required = false);
    std::optional<double> number(const std::string& key, const NumberRange& range, bool required = false);
    /// A whole number; `5.0` is one.
    std::optional<int64_t> integer(const std::string& key, int64_t min, int64_t max, bool required = false);
    std::optional<uint64_t> seed(const std::string& key);
    std::optional<std::string> word(const std::string& key, const std::vector<std::string>& words,
                                    bool required = false);
    void finish();

    /// Pointer of a member.
    std::string at(const std::string& key) const;
    BodyFaults& faults() { return faults_; }

private:
    const nlohmann::json* source_;
    std::string pointer_;
    BodyFaults& faults_;
    std::vector<std::string> known_;
};

}  // namespace photond
