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
#include "renderer/error/metric.h"
#include "renderer/frame/left_out.h"
#include "server/core_loss.h"

namespace photond {

/// What a table needs to know of one job, finished or not.
struct MeasuredJob {
    std::string id, label;
    nlohmann::json parameters;  // object: those the sweep gave
    uint64_t seed = 1;
    std::string state;
    std::vector<CurvePoint> curve;
    std::map<std::string, double> error;             // at the end
    std::map<std::string, Interval> error_interval;  // of these, where the reference is two films
    std::map<std::string, double> reference_error;   // the reference's own noise, by metric
    std::optional<uint64_t> peak_bytes;              // that rendering took beside the idle process, host and device
    uint64_t passes = 0;
    std::optional<uint64_t> photons;
    double seconds = 0;
    std::optional<CoreLoss> loss;  // of a job that was disturbed
    std::optional<PathsLeftOut> left_out;

    bool succeeded() const { return state == "succeeded"; }
    bool is_over() const { return succeeded() || state == "failed" || state == "cancelled"; }
};

struct TimeToError {
    double error = 0;
    std::optional<SeedMean> seconds;  // where every seed reached it: time_to_error(), the mean of logarithms
    size_t reached = 0;               // seeds that did
    bool at_most = false;             // some seed was there at its first point: the time is an upper bound
    /// What the references' noise leaves open, of every seed the earliest and the latest that its intervals let it have
    /// reached the error; means of logarithms. Empty where not every seed has one, and without intervals.
    std::optional<double> earliest = {}, latest = {};
    /// Of a row with disturbed jobs: when it might have been there with all processors that they wanted, at the
    /// earliest; a seed that was not there when its time was over, from that time on.
    std::optional<SeedMean> undisturbed = {};
};

/// An error over seeds. One rule: an error that has an interval is averaged as it is, for then the mean is as free of
/// the references' noise as each, may be below 0, and is what squared bias and variance add up to; so is a list in
/// which an error is 0. All others are positive, spread over decades, and known to no better than a factor: the mean is
/// that of their logarithms.
struct MeanError {
    SeedMean error;
    /// What the references' noise leaves open, at kConfidence: it is the same in all seeds, so that the mean's interval
    /// is as wide as theirs are on average, however many there are. Empty where an error has none.
    std::optional<Interval> interval = {};

    /// The error as it is drawn on a logarithmic axis: where it is not positive, an upper bound, upper_end(). Empty
    /// where there is none.
    std::optional<double> drawn() const;
    /// By which rows are compared where they cannot be asked about each time: TimedError::upper_end().
    double upper_end() const { return TimedError{0, error.mean, interval}.upper_end(); }
    /// Whether drawn() is such a bound.
    bool is_bound() const { return !(error.mean > 0); }
};

/// Empty for no errors.
std::optional<MeanError> mean_error(std::span<const TimedError> errors);

struct ErrorAtTime {
    double seconds = 0;
    std::optional<MeanError> mean;  // where every seed's curve spans that time
    size_t reached = 0;             // seeds whose curve does
};

struct FinalError {
    std::optional<MeanError> mean;    // over the seeds that are over
    std::optional<double> reference;  // the reference's own noise by the same metric
    /// Whether the reference spoils the figure. With an interval: it is not known to a third of itself, half of the
    /// interval's width being more than that. Without: the reference's noise is at least a third of it, and part of it.
    bool near_reference = false;
};

struct Spread {
    double min = 0, max = 0;
};

struct MeanPoint {
    double seconds = 0;
    MeanError mean;
    Spread seeds;  // from the lowest to the highest of the seeds' errors
};

/// What a row's error is made of, of one quadratic metric: from films of different seeds against two references.
struct BiasApart {
    double squared_bias = 0, low = 0, high = 0;         // 90 %, from the seeds and the references' noise: seed_errors.h
    double variance = 0;                                // of one film
    std::optional<double> variance_low, variance_high;  // 90 %, from the seeds; two have none
    /// The row's parameters are fixed: more passes will not go below the squared bias. Else it is that at these passes.
    bool floor = false;
    std::string text;  // a sentence

    /// The least that the row comes to whatever its passes, as far as its seeds tell; empty where that may be 0.
    std::optional<double> least() const { return floor && low > 0 ? std::optional(low) : std::nullopt; }
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
    std::optional<double> efficiency;    // 1 / the mean over the seeds of mse x seconds at the end, where above 0
    bool pareto = false;                 // at some time no other row's mean curve is better, by upper ends
    /// By metric, a mean square; empty for one seed, until it is measured, and where the reference is not two films.
    std::optional<std::map<std::string, BiasApart>> bias = {};
    std::optional<PathsLeftOut> left_out = {};  // by the first job that says so
};

/// The mean square that a metric is or is the root of: "indirect:mse" of "indirect:rmse". Empty for other metrics.
std::optional<LayerMetric> mean_square_named(const std::string& metric);
/// Of that, what the row's error is made of; null where that is not known.
const BiasApart* bias_of(const TableRow& row, const std::string& metric);
/// The error that the row does not go below, whatever its passes: BiasApart::least(), of an rmse its root.
std::optional<double> floor_of(const TableRow& row, const std::string& metric);

struct ComparisonTable {
    std::vector<std::string> metrics;
    std::vector<TableRow> rows;
    std::optional<PathsLeftOut> reference_left_out = {};  // left_out_marks.h
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
/// {metric: [{"seconds", "error", "low", "high", "min", "max", "interval"}]} of a row's mean curves.
nlohmann::json mean_curves_json(const TableRow& row);

/// "photon mapping, photons 5000": the label and what the sweep gave.
std::string row_name(const std::string& label, const nlohmann::json& parameters);

}  // namespace photond
