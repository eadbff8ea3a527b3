// main() of every GoogleTest program: which cases run, and what each costs.
//
//   PHOTOND_TEST_CASES=FILE   runs only the cases that a line of FILE names, SUITE.CASE (tests/support/select_cases.py)
//   PHOTOND_TEST_TIMES=FOLDER adds a line for each case to a file of this process there: processor seconds, tab,
//                             SUITE.CASE (tests/support/test_costs.py)

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

namespace {

double seconds_of(const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); }

/// Of this process, all threads, and of the children that it has waited for [s].
double processor_seconds() {
    double seconds = 0;
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage usage{};
        getrusage(who, &usage);
        seconds += seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
    }
    return seconds;
}

class CostOfCases final : public testing::EmptyTestEventListener {
public:
    explicit CostOfCases(const std::filesystem::path& file) : out_(file) {}

private:
    void OnTestStart(const testing::TestInfo& /*info*/) override { began_ = processor_seconds(); }
    void OnTestEnd(const testing::TestInfo& info) override {
        out_ << processor_seconds() - began_ << '\t' << info.test_suite_name() << '.' << info.name() << std::endl;
    }

    std::ofstream out_;
    double began_ = 0;
};

/// The lines of a file as a filter of GoogleTest.
std::string filter_from(const char* file) {
    std::ifstream in(file);
    std::string filter;
    for (std::string line; std::getline(in, line);) filter += (filter.empty() ? "" : ":") + line;
    return filter;
}

}  // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    if (const char* file = std::getenv("PHOTOND_TEST_CASES")) {
        const std::string filter = filter_from(file);
        if (filter.empty()) {
            std::cerr << "PHOTOND_TEST_CASES=" << file << " names no case\n";
            return EXIT_FAILURE;
        }
        testing::GTEST_FLAG(filter) = filter;
    }
    if (const char* folder = std::getenv("PHOTOND_TEST_TIMES")) {
        const std::string name = std::filesystem::path(argv[0]).stem().string() + "." + std::to_string(getpid());
        // GoogleTest deletes it.
        testing::UnitTest::GetInstance()->listeners().Append(
            new CostOfCases(std::filesystem::path(folder) / (name + ".cases")));
    }
    return RUN_ALL_TESTS();
}
