#pragma once
// The method interface: begin, passes, resolve. A method knows neither time limits nor references nor where files go;
// the job runner owns the loop (server/worker/job_runner.h).

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/param_info.h"
#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/frame/frame_before.h"
#include "renderer/frame/render_context.h"

namespace photond {

/// A file that a method can leave beside the image. `name` is one that its row in the registry declares.
struct MethodArtefact {
    std::string name;
    std::string media_type;
    std::function<void(const std::filesystem::path& path)> write;  // whole or not at all (core/atomic_file.h)
};

class Method {
public:
    virtual ~Method() = default;

    /// Said before begin(): the frame of an animation that comes before this one, and what it left. Throws
    /// ErrorCode::Conflict where that is not of this method, or of another image.
    // NOLINTNEXTLINE(performance-unnecessary-value-param): overriders keep it
    virtual void follow(FrameBefore before) {
        if (!before.left.empty()) throw Error(ErrorCode::Conflict, "the method's frames stand alone");
    }
    /// Said before begin(): passes before the one that comes first left this state(). Throws ErrorCode::Conflict where
    /// that is not of this method.
    virtual void go_on_from(const std::string& state) {
        if (!state.empty()) throw Error(ErrorCode::Conflict, "the method keeps no state from pass to pass");
    }
    /// Builds what the passes need. Called once. Throws ErrorCode::OutOfMemory before allocating past the budget.
    virtual void begin(const RenderContext& context, Stats& stats) = 0;
    /// Renders one pass, a pure function of (scene, view, parameters, seed, pass), whatever the number of threads. When
    /// `cancel` is seen the pass is left unfinished and nothing of it may reach the film.
    virtual void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) = 0;
    /// Said between run_pass() and resolve(): that pass is wanted next. A method whose work another device does begins
    /// it now, so that the device works while this pass is folded into the film, measured and written.
    virtual void expect_pass(uint32_t /*pass*/) {}
    /// Waits for what expect_pass() began: said on the job's clock before something that is off it, so that no work is
    /// done for nothing.
    virtual void settle() {}
    /// Ends the pass that run_pass() has rendered: its image, the method's own, which whoever asks may change before it
    /// goes to the film. Null where the pass was cancelled.
    virtual PassImage* end_pass() = 0;
    /// Folds the pass just finished into the film.
    void resolve(Film& film) {
        if (const PassImage* image = end_pass()) film.add_pass(*image);
    }
    /// What later passes follow from beside the pass's index, as it is after the last resolve(): kept with the film, so
    /// that another run goes on to the same bits. Empty where passes stand alone.
    virtual std::string state() const { return {}; }
    /// What the frame after this one follows from, as it is after the last end_pass(): kept with the film, so that any
    /// run of that frame comes to the same bits. Empty where frames stand alone.
    virtual std::string left_to_next() const { return {}; }
    /// What the passes leave for whoever wants to look inside. Asked once, after the last pass, when at least one was
    /// resolved; borrows from the method.
    virtual std::vector<MethodArtefact> artefacts() const { return {}; }
};

}  // namespace photond
