#pragma once
// The daemon's methods as command lines name them: METHOD[@DEVICE][,PARAMETER=VALUE...], checked before anything is
// sent.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/cli/daemon_client.h"
#include "clients/cli/parameter_schema.h"

namespace photond::cli {

/// Settings that have a column of their own where methods are judged by scenes with known answers.
struct CatalogueVariant {
    std::string label;          // after the method's name
    nlohmann::json parameters;  // the wire's
};

/// Why a method misses a known answer by its nature.
struct CatalogueLimit {
    nlohmann::json parameters;  // with these settings
    std::string row;            // part of the case's row; empty: any
    std::string text;
};

struct CatalogueMethod {
    std::string name;
    std::vector<Parameter> parameters;
    std::vector<std::string> layers;   // on request
    std::vector<std::string> devices;  // kinds: "cpu", "gpu"
    std::vector<CatalogueVariant> variants;
    std::vector<CatalogueLimit> limits;

    /// On a device by its id; empty: the default, a CPU.
    bool runs_on(const std::string& device) const;

    /// Throws Failure(Usage) that says what to ask for instead.
    void require_device(const std::string& device) const;

    /// Throws Failure(Usage) with the nearest name.
    const Parameter& parameter(const std::string& parameter_name) const;
    /// Throws Failure(Usage) with the nearest name and all there are.
    void require_layer(const std::string& layer) const;
};

class MethodCatalogue {
public:
    /// Asks the daemon. `device`: of methods whose text names none; empty: left to the daemon. Throws Failure.
    explicit MethodCatalogue(DaemonClient& daemon, std::string device = "");

    /// Throws Failure(Usage) with the nearest name.
    const CatalogueMethod& method(const std::string& name) const;
    /// The wire's `method`: {"name", "device", "parameters"}, the latter two where the text has them. Throws
    /// Failure(Usage).
    nlohmann::json method_from(const std::string& text) const;
    /// An entry of a table that compares methods, {"label", "method"}: "LABEL=METHOD[,PARAMETER=VALUE...]", or the
    /// method alone, which then is its own label. A label may not have what the rest begins with: the first '=' before
    /// any ',' ends it. Throws Failure(Usage).
    nlohmann::json entry_from(const std::string& text) const;
    /// All, by name.
    const std::vector<CatalogueMethod>& methods() const { return methods_; }

private:
    std::string device_;
    std::vector<CatalogueMethod> methods_;
};

/// The pieces of "a,b,c".
std::vector<std::string> split(const std::string& text, char separator);

}  // namespace photond::cli
