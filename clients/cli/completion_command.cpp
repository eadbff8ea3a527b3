// photonctl completion bash|zsh|fish, and the hidden `photonctl complete` which their scripts call.

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>

#include "clients/cli/commands.h"
#include "clients/cli/reference_option.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

constexpr const char* kBashScript = R"(# Completion of photonctl for bash: source <(photonctl completion bash)
_photonctl() {
    local word files= current="${COMP_WORDS[COMP_CWORD]}"
    COMPREPLY=()
    while IFS=$'\t' read -r word _; do
        if [[ $word == :files ]]; then files=1; else COMPREPLY+=("$word"); fi
    done < <(photonctl complete --line "$COMP_LINE" --point "$COMP_POINT" 2>/dev/null)
    if [[ $files ]]; then
        [[ $current == '=' ]] && current=
        while IFS= read -r word; do COMPREPLY+=("$word"); done < <(compgen -f -- "$current")
        compopt -o filenames
    fi
    [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]] && compopt -o nospace
}
complete -F _photonctl photonctl
)";

constexpr const char* kZshScript = R"(#compdef photonctl
# Completion of photonctl for zsh: photonctl completion zsh > a folder of $fpath, as _photonctl
_photonctl() {
    local line files
    local -a candidates
    for line in "${(@f)$(photonctl complete --words "${(@)words[1,CURRENT]}" 2>/dev/null)}"; do
        if [[ $line == :files* ]]; then
            files=1
        elif [[ -n $line ]]; then
            candidates+=("${${line%%$'\t'*}//:/\\:}:${line#*$'\t'}")
        fi
    done
    (( $#candidates )) && _describe photonctl candidates
    [[ -n $files ]] && _files
}
compdef _photonctl photonctl 2>/dev/null
)";

constexpr const char* kFishScript =
    R"(# Completion of photonctl for fish: photonctl completion fish > ~/.config/fish/completions/photonctl.fish
function __photonctl_complete
    for line in (photonctl complete --words (commandline -opc) (commandline -ct) 2>/dev/null)
        if string match -q ':files*' -- $line
            __fish_complete_path (commandline -ct)
        else
            echo $line
        end
    end
end
complete -c photonctl -f -a '(__photonctl_complete)'
)";

constexpr size_t kMostJobs = 50;                                         // offered for completion, the newest ones
constexpr double kPatience = 2;                                          // seconds that somebody waits for a list
constexpr const char* kPatienceVariable = "PHOTOND_COMPLETION_SECONDS";  // another patience, for a slow daemon

/// Words of a line as the shell would cut it; the last one is the one under the cursor, perhaps empty.
std::vector<std::string> shell_words(const std::string& line) {
    std::vector<std::string> words(1);
    char quote = 0;
    for (size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (quote == 0 && c == ' ') {
            if (!words.back().empty()) words.emplace_back();
        } else if (quote != '\'' && c == '\\' && i + 1 < line.size()) {
            words.back() += line[++i];
        } else if (c == quote) {
            quote = 0;
        } else if (quote == 0 && (c == '\'' || c == '"')) {
            quote = c;
        } else {
            words.back() += c;
        }
    }
    return words;
}

struct Candidate {
    std::string word;
    std::string text;
};

/// Where the cursor stands in the command line.
struct Position {
    const CLI::App* command = nullptr;
    const CLI::Option* option = nullptr;   // whose value is being written
    std::vector<std::string> positionals;  // written already, of this command
    std::string prefix;                    // "--method=" when option and value are one word
    std::string value;                     // what is written of the word to complete
};

const CLI::Option* find_option(const CLI::App* command, const std::string& name) {
    for (; command; command = command->get_parent())
        if (const CLI::Option* option = command->get_option_no_throw(name)) return option;
    return nullptr;
}

const CLI::App* find_subcommand(const CLI::App* command, const std::string& name) {
    for (const CLI::App* sub : command->get_subcommands(nullptr))
        if (sub->get_name() == name) return sub;
    return nullptr;
}

Position position_of(const CLI::App& program, const std::vector<std::string>& words) {
    Position position;
    position.command = &program;
    for (size_t i = 1; i + 1 < words.size(); ++i) {
        const std::string& word = words[i];
        if (position.option) {
            position.option = nullptr;  // this word was its value
        } else if (word.starts_with("-") && word.size() > 1) {
            const CLI::Option* option = find_option(position.command, word.substr(0, word.find('=')));
            if (option && option->get_items_expected_max() > 0 && word.find('=') == std::string::npos)
                position.option = option;
        } else if (const CLI::App* sub = find_subcommand(position.command, word)) {
            position.command = sub;
            position.positionals.clear();
        } else {
            position.positionals.push_back(word);
        }
    }
    position.value = words.empty() ? "" : words.back();
    const size_t equals = position.value.find('=');
    if (!position.option && position.value.starts_with("--") && equals != std::string::npos) {
        position.option = find_option(position.command, position.value.substr(0, equals));
        position.prefix = position.value.substr(0, equals + 1);
        position.value.erase(0, equals + 1);
    }
    return position;
}

class Completer {
public:
    Completer(Session& session, std::vector<std::string> words) : session_(session), words_(std::move(words)) {}

    std::vector<Candidate> candidates() {
        const RenderVocabulary vocabulary = render_vocabulary();
        const std::unique_ptr<CLI::App> program = make_program(session_, vocabulary);
        const Position position = position_of(*program, words_);
        vocabulary_ = &vocabulary;
        if (position.option) {
            add_values(position.option->get_type_name(), position);
        } else if (position.value.starts_with("-")) {
            add_options(position.command);
        } else {
            for (const CLI::App* sub : position.command->get_subcommands(nullptr))
                if (!sub->get_group().empty()) add(sub->get_name(), sub->get_description());
            add_positional(position);
        }
        std::vector<Candidate> matching;
        for (Candidate& candidate : found_)
            if (candidate.word == ":files" || candidate.word.starts_with(position.value)) {
                if (candidate.word != ":files") candidate.word = position.prefix + candidate.word;
                matching.push_back(std::move(candidate));
            }
        return matching;
    }

private:
    RenderVocabulary render_vocabulary() {
        RenderVocabulary vocabulary;
        vocabulary.method.name = kDefaultMethod;
        if (!names_a_method(words_)) return vocabulary;
        const std::vector<std::string> complete_words(words_.begin(), words_.end() - 1);
        try {
            return ask_render_vocabulary(session_, complete_words);
        } catch (const Failure&) {
            return vocabulary;
        }
    }

    void add(const std::string& word, const std::string& text) { found_.push_back({printable(word), printable(text)}); }

    void add_options(const CLI::App* command) {
        for (; command; command = command->get_parent())
            for (const CLI::Option* option : command->get_options())
                for (const std::string& name : option->get_lnames()) add("--" + name, option->get_description());
    }

    void add_positional(const Position& position) {
        size_t index = position.positionals.size();
        for (const CLI::Option* option : position.command->get_options()) {
            if (!option->get_positional()) continue;
            const auto most = static_cast<size_t>(std::max(option->get_items_expected_max(), 1));
            if (index < most) return add_values(option->get_type_name(), position);
            index -= most;
        }
    }

    void add_devices() {
        const json items = session_.daemon().get("/v1/devices").at("items");
        for (const json& item : items)
            if (item.value("served", true))
                add(item.at("id").get<std::string>(), plain_text(item.value("name", json())));
    }

    /// `kind`: an option's value name.
    void add_values(const std::string& kind, const Position& position) {
        try {
            if (kind == "SCENE") return add_scenes(position);
            if (kind == "COMPARISON")
                return add_items("/v1/comparisons?limit=" + std::to_string(kMostJobs), "id", "state");
            if (kind == "SEQUENCE") return add_items("/v1/sequences?limit=" + std::to_string(kMostJobs), "id", "state");
            if (kind == "REFERENCE" || kind == "IMAGE") return add_images(kind == "REFERENCE");
            if (kind == "METRICS") return add_listed(position, metric_names(session_.daemon()));
            if (kind == "METRIC=VALUE") return add_targets();
            if (kind == kEntryKind) return add_entry(position);
            if (kind == "JOB") return add_items("/v1/jobs?limit=" + std::to_string(kMostJobs), "id", "state");
            if (kind == "METHOD") return add_items("/v1/methods", "name", "title");
            if (kind == "DEVICE") return add_devices();
            if (kind == "CAMERA") return add_cameras(position);
            if (kind == "NAME=VALUE") return add_settings(position);
            if (kind == "LAYERS") return add_listed(position, vocabulary_->method.layers);
            if (kind == "FILE") return found_.push_back({":files", ""});
            if (kind.find('|') == std::string::npos) return;
            for (size_t begin = 0; begin <= kind.size();) {
                const size_t end = std::min(kind.find('|', begin), kind.size());
                add(kind.substr(begin, end - begin), "");
                begin = end + 1;
            }
        } catch (const Failure&) {  // no daemon, no candidates
        } catch (const json::exception&) {
        }
    }

    void add_items(const std::string& path, const char* name, const char* text) {
        const json items = session_.daemon().get(path).at("items");
        for (const json& item : items) add(item.at(name).get<std::string>(), plain_text(item.value(text, json())));
    }

    void add_scenes(const Position& position) {
        if (const std::string command = position.command->get_name();
            command == "render" || command == "sequence" || command == "compare" || command == "bake")
            found_.push_back({":files", ""});
        const json scenes = session_.daemon().get("/v1/scenes?limit=1000").at("items");
        for (const json& scene : scenes) {
            const json triangles = scene.value("triangles", json());
            const std::string text = triangles.is_number() ? human_count(triangles.get<double>()) + " triangles" : "";
            const json name = scene.value("name", json());
            add(name.is_string() && !name.get<std::string>().empty() ? name.get<std::string>()
                                                                     : scene.at("id").get<std::string>(),
                text);
        }
    }

    void add_cameras(const Position& position) {
        if (position.positionals.empty()) return;
        const json scene = session_.daemon().get(resource_path("scenes", position.positionals.front()));
        for (const json& camera : scene.at("cameras")) add(camera.at("name").get<std::string>(), "");
    }

    void add_settings(const Position& position) {
        const size_t equals = position.value.find('=');
        for (const Parameter& parameter : vocabulary_->method.parameters) {
            if (equals == std::string::npos) {
                add(parameter.name + "=", parameter.help());
            } else if (position.value.substr(0, equals) == parameter.name) {
                std::vector<std::string> words = parameter.words;
                if (parameter.is_boolean) words = {"true", "false"};
                for (const std::string& word : words) add(parameter.name + "=" + word, "");
            }
        }
    }

    /// Words of a list with commas, after those already written.
    void add_listed(const Position& position, const std::vector<std::string>& words) {
        const std::string written = position.value.substr(0, position.value.rfind(',') + 1);
        for (const std::string& word : words) add(written + word, "");
    }

    /// What can be measured, and what against.
    void add_images(bool reference) {
        found_.push_back({":files", ""});
        add_items("/v1/jobs?state=succeeded&limit=" + std::to_string(kMostJobs), "id", "state");
        const json methods = reference ? session_.daemon().get("/v1/methods").at("items") : json::array();
        for (const json& method : methods)
            add(method.at("name").get<std::string>() + ":", "rendered with this many passes");
    }

    void add_targets() {
        for (const std::string& metric : metric_names(session_.daemon())) add(metric + "=", "");
    }

    /// The method of an entry, after its label; then its parameters.
    void add_entry(const Position& position) {
        const size_t comma = position.value.rfind(',');
        const size_t equals = position.value.find('=');
        const bool labelled = equals != std::string::npos && equals < position.value.find(',');
        const size_t begin = labelled ? equals + 1 : 0;
        if (comma == std::string::npos) {
            const json methods = session_.daemon().get("/v1/methods").at("items");
            for (const json& method : methods)
                add(position.value.substr(0, begin) + method.at("name").get<std::string>(),
                    plain_text(method.value("title", json())));
            return;
        }
        const std::string name = position.value.substr(begin, position.value.find_first_of("@,", begin) - begin);
        for (const Parameter& parameter : MethodCatalogue(session_.daemon()).method(name).parameters)
            add(position.value.substr(0, comma + 1) + parameter.name + "=", parameter.help());
    }

    Session& session_;
    std::vector<std::string> words_;
    const RenderVocabulary* vocabulary_ = nullptr;
    std::vector<Candidate> found_;
};

std::chrono::duration<double> patience() {
    const char* text = std::getenv(kPatienceVariable);
    double seconds = text ? std::strtod(text, nullptr) : kPatience;
    if (!(seconds > 0 && seconds <= 3600)) seconds = kPatience;  // a completion has nowhere to complain
    return std::chrono::duration<double>(seconds);
}

void print(const std::vector<Candidate>& candidates, size_t cut) {
    for (const Candidate& candidate : candidates) {
        const std::string word =
            candidate.word == ":files" ? candidate.word : candidate.word.substr(std::min(cut, candidate.word.size()));
        std::cout << word << (candidate.text.empty() ? "" : "\t" + candidate.text) << '\n';
    }
}

}  // namespace

void complete(Session& session, const std::vector<std::string>& arguments) {
    session.server.retry_seconds = 0;
    session.interrupt().set_deadline(patience());
    std::vector<std::string> words;
    size_t cut = 0;
    if (arguments.size() == 4 && arguments[0] == "--line" && arguments[2] == "--point") {
        const size_t point = std::min<size_t>(std::strtoul(arguments[3].c_str(), nullptr, 10), arguments[1].size());
        words = shell_words(arguments[1].substr(0, point));
        // bash cuts words at '=' and ':' (COMP_WORDBREAKS) and replaces only what follows the last of them
        if (const size_t last_break = words.back().find_last_of("=:"); last_break != std::string::npos)
            cut = last_break + 1;
    } else if (arguments.size() > 1 && arguments[0] == "--words") {
        words.assign(arguments.begin() + 1, arguments.end());
    }
    if (words.size() < 2) return;
    if (const std::string url = argument_of(words, {"--server"}); !url.empty()) session.server.url = url;
    session.token_file = argument_of(words, {"--token-file"});
    print(Completer(session, words).candidates(), cut);
}

void add_completion_command(CLI::App& program, Session& session) {
    CLI::App* command = program.add_subcommand("completion", "Print the completion script of a shell");
    command->footer(
        "bash: source <(photonctl completion bash)\n"
        "zsh:  photonctl completion zsh > \"${fpath[1]}/_photonctl\"\n"
        "fish: photonctl completion fish > ~/.config/fish/completions/photonctl.fish\n"
        "A list that the daemon must give is waited for 2 s, or PHOTOND_COMPLETION_SECONDS.");
    const auto shell = std::make_shared<std::string>();
    command->add_option("shell", *shell, "which shell")
        ->required()
        ->type_name("bash|zsh|fish")
        ->check(CLI::IsMember({"bash", "zsh", "fish"}).description(""));
    command->callback([&session, shell] {
        session.action = [shell] {
            std::cout << (*shell == "bash" ? kBashScript : *shell == "zsh" ? kZshScript : kFishScript);
            return ExitCode::Ok;
        };
    });
}

}  // namespace photond::cli
