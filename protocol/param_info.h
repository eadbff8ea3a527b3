#pragma once
// How a method's parameters are declared: once, with unit, range and meaning. Readers (strict JSON parse, echo, JSON
// Schema) are visitors over the declaration. No JSON here, so that the renderer may include it.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace photond {

/// What a parameter is about. Forms show a group together, in this order; the first is what one changes first.
enum class ParamGroup : uint8_t {
    Light,
    LightMaps,
    Gathering,
    DensityEstimate,
    Stratification,
    Splats,
    Visibility,
    NoiseAndBias,
    Frames,
    Filter,
    Device,
    Files,
};
inline constexpr std::array<std::string_view, 12> kParamGroupTitles = {"Light",
                                                                       "Light sources' maps",
                                                                       "Gathering",
                                                                       "Density estimate",
                                                                       "Stratification",
                                                                       "Splats",
                                                                       "Shadows and voxels",
                                                                       "Noise and bias",
                                                                       "From frame to frame",
                                                                       "Filter",
                                                                       "On a GPU",
                                                                       "Files"};

struct ParamInfo {
    ParamGroup group;
    std::string_view unit;  // SI unit or "" for a plain number
    double min = 0;         // least accepted value
    double max = 0;         // greatest accepted value
    std::string_view text;  // one line of help
};

/// A parameter that is one of a fixed list of words; `value` is an index into `words`.
struct ParamChoice {
    ParamGroup group;
    std::span<const std::string_view> words;
    std::string_view text;
};

struct ParamFlag {
    ParamGroup group;
    std::string_view text;
};

/// Called once for each parameter, in the order of declaration, with the value to read or write in place.
class ParamVisitor {
public:
    virtual ~ParamVisitor() = default;
    virtual void field(std::string_view key, float& value, const ParamInfo& info) = 0;
    virtual void field(std::string_view key, uint32_t& value, const ParamInfo& info) = 0;
    /// An empty value means "not given": null in the echo, absent from the schema's defaults.
    virtual void field(std::string_view key, std::optional<float>& value, const ParamInfo& info) = 0;
    virtual void field(std::string_view key, std::optional<uint32_t>& value, const ParamInfo& info) = 0;
    virtual void flag(std::string_view key, bool& value, const ParamFlag& info) = 0;
    virtual void choice(std::string_view key, uint32_t& value, const ParamChoice& choice) = 0;

    /// An enum whose values are 0, 1, 2 ... in the order of `words`.
    template <class Enum>
    void enumeration(std::string_view key, Enum& value, const ParamChoice& choices) {
        uint32_t index = static_cast<uint32_t>(value);
        choice(key, index, choices);
        value = static_cast<Enum>(index);
    }
};

/// The parameters of one method: a struct with default initialisers that shows each of its fields to a visitor.
class MethodParams {
public:
    virtual ~MethodParams() = default;
    virtual void visit(ParamVisitor& visitor) = 0;
    /// Faults that no single field's range can express (two fields that exclude each other); throws photond::Error.
    virtual void check() const {}
};

}  // namespace photond
