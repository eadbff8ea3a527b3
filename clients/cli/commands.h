#pragma once
// The commands. Each function adds its subcommand to the program; parsing sets Session::action, which main() runs.
//
// An option's value name is also what completion asks for: SCENE, JOB, COMPARISON, SEQUENCE, METHOD, DEVICE, CAMERA,
// LAYERS, METRICS, METRIC=VALUE, REFERENCE, IMAGE, NAME=VALUE, FILE, kEntryKind, or words separated by '|'.

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/cli/method_catalogue.h"
#include "clients/cli/session.h"

namespace photond::cli {

/// scenes add|list|show|remove, and bake
void add_scenes_commands(CLI::App& program, Session& session);
void add_jobs_commands(CLI::App& program, Session& session);
/// methods, devices, status
void add_catalogue_commands(CLI::App& program, Session& session);
/// compare SCENE
void add_compare_command(CLI::App& program, Session& session);
/// comparisons list|show|watch|cancel|remove|fetch
void add_comparisons_commands(CLI::App& program, Session& session);
/// hard-cases
void add_hard_cases_command(CLI::App& program, Session& session);
/// merge and metrics: what is made of finished jobs and images
void add_film_commands(CLI::App& program, Session& session);
/// backup and restore
void add_backup_commands(CLI::App& program, Session& session);
void add_doctor_command(CLI::App& program, Session& session);
void add_completion_command(CLI::App& program, Session& session);

/// What the help and the checks of `render` need from the daemon.
struct RenderVocabulary {
    CatalogueMethod method;  // the one the command line names; its name alone where the daemon did not answer
    bool known = false;      // the daemon was asked and has that method
};
void add_render_command(CLI::App& program, Session& session, const RenderVocabulary& vocabulary);
/// repeat IMAGE
void add_repeat_command(CLI::App& program, Session& session);
/// sequence SCENE, and sequences list|show|watch|cancel|remove|fetch
void add_sequence_commands(CLI::App& program, Session& session, const RenderVocabulary& vocabulary);

/// The whole program. Throws nothing but what CLI11 throws for a defect of ours.
std::unique_ptr<CLI::App> make_program(Session& session, const RenderVocabulary& vocabulary);

/// The last value of an option in unparsed arguments: --name VALUE or --name=VALUE; empty when it is not there.
std::string argument_of(const std::vector<std::string>& arguments, const std::vector<std::string>& names);
/// Whether a command of `arguments` takes a method's parameters as options.
bool names_a_method(const std::vector<std::string>& arguments);
inline const char* const kDefaultMethod = "path_tracing";
inline const char* const kEntryKind = "[LABEL=]METHOD[,NAME=VALUE...]";
/// Asks the daemon for the method that `arguments` of `render` or `sequence` name. Throws Failure.
RenderVocabulary ask_render_vocabulary(Session& session, const std::vector<std::string>& arguments);

/// The hidden command of the completion scripts: `--words WORD...` (the last is being written) or, for bash, `--line
/// LINE
/// --point CURSOR`, whose candidates continue after the last '=' or ':' as bash cuts words. One candidate a line, TAB
/// and a description after it; the line ":files" asks the shell for file names as well. Silent when no daemon answers
/// soon.
void complete(Session& session, const std::vector<std::string>& arguments);

}  // namespace photond::cli
