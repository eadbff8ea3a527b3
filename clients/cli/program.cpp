#include "clients/cli/program.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/problem_view.h"
#include "clients/cli/units.h"
#include "protocol/nearest_name.h"

namespace photond::cli {

namespace {

using nlohmann::json;

/// The daemon's code where it refused, else what the exit code stands for.
json code_of(const Failure& failure) {
    if (failure.problem.is_object() && failure.problem.contains("code")) return failure.problem["code"];
    for (const ExitCodeRow& row : kExitCodes)
        if (row.code == failure.code) return row.name;
    return nullptr;
}

void print_failure(const Session& session, const Failure& failure) {
    remark_problem(session, "photonctl: ", failure.what(), failure.problem);
    if (!failure.hint.empty()) session.remark("  " + failure.hint);
    if (session.json_output)
        session.print_json({{"failure",
                             {{"exit_code", static_cast<int>(failure.code)},
                              {"code", code_of(failure)},
                              {"message", failure.what()},
                              {"hint", failure.hint.empty() ? json() : json(failure.hint)},
                              {"problem", failure.problem}}}});
}

std::string exit_code_text() {
    std::string text = "Exit codes:\n";
    for (const ExitCodeRow& row : kExitCodes) {
        const std::string code = std::to_string(static_cast<int>(row.code));
        text += "  " + code + std::string(6 - code.size(), ' ') + row.meaning + "\n";
    }
    return text +
           "\nWith --json standard output is JSON Lines: the daemon's own objects, one a line; a failure is\n"
           "{\"failure\": {\"exit_code\", \"code\", \"message\", \"hint\", \"problem\"}}. Progress and remarks go to "
           "standard\n"
           "error.\n"
           "PHOTOND_URL is the daemon's address, PHOTOND_TOKEN its bearer token.";
}

/// The subcommand that the arguments reached, innermost.
const CLI::App& innermost(const CLI::App& program) {
    const CLI::App* current = &program;
    while (!current->get_subcommands().empty()) current = current->get_subcommands().front();
    return *current;
}

/// "did you mean --width?" for the first argument that nothing took.
std::string suggestion(const CLI::App& program) {
    const std::vector<std::string> extras = program.remaining(true);
    const CLI::App& command = innermost(program);
    if (extras.empty()) return "";
    // CLI11 hands the extras back in an order of its own; the first that looks like an option is the likeliest slip.
    const auto option =
        std::find_if(extras.begin(), extras.end(), [](const auto& extra) { return extra.starts_with("-"); });
    const std::string& extra = option == extras.end() ? extras.front() : *option;
    const std::string wrong = extra.substr(0, extra.find('='));
    std::vector<std::string> known;
    for (const CLI::App* app = &command; app; app = app->get_parent())
        for (const CLI::Option* known_option : app->get_options())
            for (const std::string& name : known_option->get_lnames()) known.push_back("--" + name);
    for (const CLI::App* sub : command.get_subcommands(nullptr)) known.push_back(sub->get_name());
    const std::string near = nearest_name(wrong, known);
    return near.empty() ? "" : "did you mean " + near + "?";
}

std::string joined_names(const std::vector<const CLI::App*>& commands) {
    std::string text;
    for (const CLI::App* command : commands)
        if (!command->get_group().empty()) text += (text.empty() ? "" : ", ") + command->get_name();
    return text;
}

/// "photonctl jobs"
std::string command_line_of(const CLI::App& program) {
    std::string line = program.get_name();
    for (const CLI::App* app = &program; !app->get_subcommands().empty();) {
        app = app->get_subcommands().front();
        line += " " + app->get_name();
    }
    return line;
}

/// Where a command is missing or is none: which word it was, what was meant, and which there are.
std::optional<Failure> command_fault(const CLI::App& program) {
    const CLI::App& parent = innermost(program);
    const std::vector<const CLI::App*> commands = parent.get_subcommands([](const CLI::App*) { return true; });
    if (commands.empty()) return std::nullopt;
    const std::string line = command_line_of(program);
    const std::string there_are = line + " has the commands " + joined_names(commands);
    const std::vector<std::string> extras = program.remaining(true);
    const auto word =
        std::find_if(extras.begin(), extras.end(), [](const auto& extra) { return !extra.starts_with("-"); });
    if (word == extras.end()) {
        if (!extras.empty()) return std::nullopt;  // an option that is none
        return Failure(ExitCode::Usage, line + " needs a command", there_are);
    }
    std::vector<std::string> known;
    known.reserve(commands.size());
    for (const CLI::App* command : commands) known.push_back(command->get_name());
    const std::string near = nearest_name(*word, known);
    return Failure(ExitCode::Usage, "there is no command " + line + " " + printable(*word),
                   near.empty() ? there_are : "did you mean " + line + " " + near + "?");
}

bool asks_for_help(const std::vector<std::string>& arguments) {
    return std::any_of(arguments.begin(), arguments.end(),
                       [](const std::string& argument) { return argument == "--help" || argument == "-h"; });
}

/// `render` and `sequence` need to know their method's parameters before their arguments can be read.
RenderVocabulary vocabulary_for(Session& session, const std::vector<std::string>& arguments) {
    RenderVocabulary vocabulary;
    vocabulary.method.name = kDefaultMethod;
    if (!names_a_method(arguments)) return vocabulary;
    if (const std::string url = argument_of(arguments, {"--server"}); !url.empty()) session.server.url = url;
    session.token_file = argument_of(arguments, {"--token-file"});
    const bool help = asks_for_help(arguments);
    if (help) session.server.retry_seconds = 0;
    try {
        vocabulary = ask_render_vocabulary(session, arguments);
    } catch (const Failure& failure) {
        if (!help || failure.code == ExitCode::Usage) throw;
    }
    return vocabulary;  // help without the method's parameters says so at its end
}

ExitCode run(Session& session, const std::vector<std::string>& arguments) {
    if (!arguments.empty() && arguments.front() == "complete") {
        complete(session, {arguments.begin() + 1, arguments.end()});
        return ExitCode::Ok;
    }
    session.json_output = std::find(arguments.begin(), arguments.end(), "--json") != arguments.end();
    const std::unique_ptr<CLI::App> program = make_program(session, vocabulary_for(session, arguments));
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // CLI11 takes them from the back
    try {
        program->parse(reversed);
    } catch (const CLI::Success& asked) {  // help or version
        program->exit(asked);
        return ExitCode::Ok;
    } catch (const CLI::ExtrasError& error) {
        throw Failure(ExitCode::Usage, error.what(), suggestion(*program));
    } catch (const CLI::ParseError& error) {
        if (const std::optional<Failure> fault = command_fault(*program)) throw *fault;
        const std::string meant = suggestion(*program);
        throw Failure(ExitCode::Usage, error.what(),
                      meant.empty() ? command_line_of(*program) + " --help explains" : meant);
    }
    return session.action();
}

}  // namespace

bool names_a_method(const std::vector<std::string>& arguments) {
    return std::any_of(arguments.begin(), arguments.end(),
                       [](const std::string& argument) { return argument == "render" || argument == "sequence"; });
}

std::unique_ptr<CLI::App> make_program(Session& session, const RenderVocabulary& vocabulary) {
    auto program = std::make_unique<CLI::App>("photonctl: render glTF scenes with a photond daemon", "photonctl");
    program->set_version_flag("--version", "photonctl " PHOTOND_VERSION);
    program->get_formatter()->column_width(38);
    program->require_subcommand(1);
    program->fallthrough();
    program->add_flag("--json", session.json_output, "machine-readable results on standard output");
    program
        ->add_option("--server", session.server.url,
                     "address of the daemon; default: http://127.0.0.1:8080, or PHOTOND_URL")
        ->type_name("URL");
    program->add_option("--token-file", session.token_file, "file with the bearer token; default: PHOTOND_TOKEN itself")
        ->type_name("FILE");
    program
        ->add_option("--retry-seconds", session.server.retry_seconds,
                     "how long to repeat what may pass: 429, 503, a lost connection; default: 30")
        ->type_name("SECONDS")
        ->check(CLI::Range(0.0, 86400.0).description(""));
    add_render_command(*program, session, vocabulary);
    add_repeat_command(*program, session);
    add_sequence_commands(*program, session, vocabulary);
    add_scenes_commands(*program, session);
    add_compare_command(*program, session);
    add_comparisons_commands(*program, session);
    add_hard_cases_command(*program, session);
    add_jobs_commands(*program, session);
    add_film_commands(*program, session);
    add_catalogue_commands(*program, session);
    add_backup_commands(*program, session);
    add_doctor_command(*program, session);
    add_completion_command(*program, session);
    program->footer(exit_code_text());  // set last: commands inherit what stands when they are added
    for (CLI::App* command : program->get_subcommands(nullptr)) {
        command->fallthrough();
        for (CLI::App* inner : command->get_subcommands(nullptr)) inner->fallthrough();
    }
    return program;
}

std::string argument_of(const std::vector<std::string>& arguments, const std::vector<std::string>& names) {
    std::string value;
    for (size_t i = 0; i < arguments.size(); ++i)
        for (const std::string& name : names) {
            if (arguments[i] == name && i + 1 < arguments.size()) value = arguments[i + 1];
            if (arguments[i].starts_with(name + "=")) value = arguments[i].substr(name.size() + 1);
        }
    return value;
}

int photonctl(const std::vector<std::string>& arguments) {
    Session session;
    try {
        return static_cast<int>(run(session, arguments));
    } catch (const Failure& failure) {
        print_failure(session, failure);
        return static_cast<int>(failure.code);
    } catch (const nlohmann::json::exception& error) {
        print_failure(
            session,
            Failure(std::string("the daemon's answer is not what the protocol says: ") + error.what(), nullptr));
    } catch (const std::exception& error) {
        print_failure(session, Failure(ExitCode::LocalFile, error.what()));
        return static_cast<int>(ExitCode::LocalFile);
    }
    return static_cast<int>(ExitCode::Refused);
}

}  // namespace photond::cli
