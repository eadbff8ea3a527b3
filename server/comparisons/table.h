#pragma once
// The tables of a comparison: what its jobs' curves say of each row, over the seeds (conventions.md, "Error";
// protocol.md, "Shapes").

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/error/curve.h"
#include "server/core_loss.h"

namespace photond {

/// What a table needs to know of one job, finished or not.
struct MeasuredJob {
    std::string id, label;
    nlohmann::json parameters;  // object: those the sweep gave
    uint64_t seed = 1;
    std::string state;
    std::vector<CurvePoint> curve;
    std::map<std::string, double> error;            // at the end
    std::map<std::string, double> reference_error;  // the reference's own noise, by metric
    std::optional<uint64_t> peak_bytes;             // that rendering took beside the idle process, host and device
    uint64_t passes = 0;
    std::optional<uint64_t> photons;
    double seconds = 0;
    std::optional<CoreLoss> loss;  // of a job that was disturbed

    bool succeeded() const { return state == "succeeded"; }
    bool is_over() const { return succeeded() || state == "failed" || state == "cancelled"; }
};

struct TimeToError {
    double error = 0;
    std::optional<LogMean> seconds;  // where every seed reached it, for good
    size_t reached = 0;              // seeds that did
    bool at_most = false;            // some seed was there at its first point: the time is an upper bound
    /// Of a row with disturbed jobs: when it might have been there with all processors that they wanted, at the
    /// earliest; a seed that was not there when its time was over, from that time on.
    std::optional<LogMean> earliest = {};
};

struct ErrorAtTime {
    double seconds = 0;
    std::optional<LogMean> error;  // where every seed's curve spans that time
    size_t reached = 0;            // seeds whose curve does
};

struct FinalError {
    std::optional<LogMean> error;     // over the seeds that are over
    std::optional<double> reference;  // the reference's own noise by the same metric
    /// Whether that noise is at least a third of what is measured: the figure is then partly the reference's.
    bool near_reference = false;
};

struct Spread {
    double min = 0, max = 0;
};

struct MeanPoint {
    double seconds = 0;
    LogMean error;
    Spread seeds;  // from the lowest to the highest of the seeds' errors
};

/// The jobs of one label and one set of parameters; they differ by their seed.
struct TableRow {
    std::string label;
    nlohmann::json parameters;
    std::vector<std::string> jobs;
    size_t seeds = 0, succeeded = 0;
    size_t disturbed = 0;                            // of these
    std::optional<Spread> passes, photons, seconds;  // over the seeds that are over
    std::map<std::string, std::vector<TimeToError>> time_to_error;
    std::map<std::string, std::vector<ErrorAtTime>> error_at_time;
    std::map<std::string, FinalError> error;
    /// The mean over the seeds where all their curves overlap, at the times of the first seed's points.
    std::map<std::string, std::vector<MeanPoint>> mean_curve;
    std::optional<uint64_t> peak_bytes;  // the largest of the seeds'
    std::optional<double> efficiency;    // 1 / (mse x seconds) at the end, mean over the seeds
    bool pareto = false;                 // at some time no other row's mean curve is better
};

struct ComparisonTable {
    std::vector<std::string> metrics;
    std::vector<TableRow> rows;
};

/// What is asked for beside the levels and times of the tables' own choice.
struct TableWishes {
    std::map<std::string, double> error;  // by metric
    std::optional<double> seconds;
};

/// `jobs` in the order they were planned, rows after each other; they may be at any stage. The first metric decides the
/// Pareto front.
ComparisonTable make_table(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics,
                           const TableWishes& wishes = {});

/// Array of rows as on the wire (protocol.md, "Shapes").
nlohmann::json to_json(const ComparisonTable& table);
/// {metric: [{"seconds", "error", "low", "high", "min", "max"}]} of a row's mean curves.
nlohmann::json mean_curves_json(const TableRow& row);

/// "photon mapping, photons 5000": the label and what the sweep gave.
std::string row_name(const std::string& label, const nlohmann::json& parameters);

}  // namespace photond
