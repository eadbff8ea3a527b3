// Processes that say what they should not: nothing they say ends the daemon, which replaces them.

#include "server/workers/worker_process.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <utility>

#include "protocol/worker_messages.h"
#include "server/workers/helper.h"
#include "tests/support/temporary_folder.h"

namespace photond::worker_process_test {
namespace {

using nlohmann::json;

class WorkerProcessTest : public testing::Test {
protected:
    /// A worker program that runs this script, with its end of the socket as file descriptor 3, and waits to be killed.
    ProcessOptions script(const std::string& lines) const {
        const std::filesystem::path program = folder_.path() / "worker";
        std::ofstream(program) << "#!/bin/sh\n" << lines << "\nexec sleep 1000 3>&3\n";
        std::filesystem::permissions(program, std::filesystem::perms::owner_all);
        ProcessOptions options;
        options.program = program;
        options.device = "none";
        return options;
    }
    /// How the first process of the script ends whose messages the daemon reads.
    ProcessExit end_of(const std::string& lines) const {
        std::promise<ProcessExit> ended;
        bool told = false;
        WorkerProcess process(script(lines), {.message = [](const json& message) { read_worker_message(message); },
                                              .exited =
                                                  [&](const ProcessExit& exit) {
                                                      if (!std::exchange(told, true)) ended.set_value(exit);
                                                  },
                                              .tick = [] {}});
        return ended.get_future().get();
    }

private:
    const TemporaryFolder folder_;
};

TEST_F(WorkerProcessTest, IsKilledForAMessageThatCannotBeRead) {
    const ProcessExit exit = end_of(R"(echo '{"type": "hello", "pid": "mine", "device": null}' >&3)");
    EXPECT_EQ(exit.cause, ExitCause::Crashed);
    EXPECT_NE(exit.text.find("\"hello\": /pid must be a whole number"), std::string::npos) << exit.text;
    EXPECT_FALSE(exit.had_answered);
}

TEST_F(WorkerProcessTest, MayMakeUpTypesOfMessages) {
    const ProcessExit exit = end_of(R"(echo '{"type": 5}' >&3; echo '{"type": "dance"}' >&3; exit 7)");
    EXPECT_EQ(exit.text, "ended with status 7");
}

TEST_F(WorkerProcessTest, OfTheHelperIsReplacedWhenItsAnswerIsNone) {
    const auto answers = [&](const char* reply) {
        return script(R"(echo '{"type": "hello", "pid": 1, "device": null, )"
                      R"("file_access": {"by": "none", "version": null}}' >&3; read request <&3; echo ')" +
                      std::string(reply) + "' >&3");
    };
    const auto failure = [&](const char* reply) {
        Helper helper(
            answers(reply), 60, [] {}, [](const ProcessExit&) {});
        try {
            helper.ask(UnpackRequest{"/zip", "/root"});
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::WorkerCrashed);
            return std::string(error.what());
        }
        return std::string("none");
    };
    EXPECT_EQ(failure(R"({"type": "reply", "request": 1, "result": {"file": "/root/a.glb"}, "failure": null})"),
              "none");
    const std::string wrong = failure(R"({"type": "reply", "request": 1, "result": {"file": 5}, "failure": null})");
    EXPECT_NE(wrong.find("\"unpack\": /file must be text"), std::string::npos) << wrong;
    const std::string nothing = failure(R"({"type": "reply", "request": 1, "result": null, "failure": null})");
    EXPECT_NE(nothing.find("neither a result nor a failure"), std::string::npos) << nothing;
    const std::string no_failure = failure(R"({"type": "reply", "request": 1, "result": null, "failure": "bad"})");
    EXPECT_NE(no_failure.find("/failure must be an object"), std::string::npos) << no_failure;
}

}  // namespace
}  // namespace photond::worker_process_test
