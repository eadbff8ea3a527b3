#pragma once
// A request's query, read as strictly as a body.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace photond::http {

class Query {
public:
    explicit Query(const std::multimap<std::string, std::string>& values) : values_(values) {}

    std::string text(const std::string& name, const std::string& otherwise = "");
    /// "a,b,c"; none where it is empty or not there.
    std::vector<std::string> list(const std::string& name);
    double number(const std::string& name, double otherwise);
    std::optional<double> number(const std::string& name);
    /// "x,y,z".
    std::optional<std::array<double, 3>> point(const std::string& name);
    uint32_t integer(const std::string& name, uint32_t otherwise);
    std::optional<uint32_t> integer(const std::string& name);
    bool flag(const std::string& name, bool otherwise = false);
    /// Throws Error with every fault found, unknown and repeated names among them. Call it before using the values.
    void finish();

private:
    const std::multimap<std::string, std::string>& values_;
    std::vector<std::string> known_;
    std::vector<Fault> faults_;
};

}  // namespace photond::http
