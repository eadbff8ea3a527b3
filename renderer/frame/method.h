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
    /// Folds the pass just finished into the film.
    virtual void resolve(Film& film) = 0;
    /// What later passes follow from beside the pass's index, as it is after the last resolve(): kept with the film, so
    /// that another run goes on to the same bits. Empty where passes stand alone.
    virtual std::string state() const { return {}; }
    /// What the passes leave for whoever wants to look inside. Asked once, after the last pass, when at least one was
    /// resolved; borrows from the method.
    virtual std::vector<MethodArtefact> artefacts() const { return {}; }
};

}  // namespace photond
