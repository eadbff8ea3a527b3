// photonctl backup|restore: a daemon's data in a folder, fetched while jobs run, and put back for one that does not.

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "clients/cli/commands.h"
#include "clients/cli/http_client.h"
#include "clients/cli/output_file.h"
#include "clients/cli/transfer.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The list of its files, written last: a folder without it is no whole backup.
constexpr const char* kListName = "backup.json";

/// Makes the folder, or finds it empty. Throws Failure.
void require_empty_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw Failure(ExitCode::LocalFile, "cannot make " + folder.string() + ": " + error.message());
    if (!fs::is_empty(folder, error) || error)
        throw Failure(ExitCode::LocalFile, folder.string() + (error ? ": " + error.message() : " is not empty"),
                      "name a new folder");
}

/// Below `folder`; its own folders are made. A path that leads out of it is no backup's.
fs::path place_below(const fs::path& folder, const std::string& path) {
    const fs::path relative = fs::path(path).lexically_normal();
    if (relative.empty() || relative.is_absolute() || *relative.begin() == "..")
        throw Failure(ExitCode::LocalFile, "the backup names a file outside of itself: " + path);
    std::error_code error;
    fs::create_directories((folder / relative).parent_path(), error);
    if (error) throw Failure(ExitCode::LocalFile, "cannot make a folder for " + path + ": " + error.message());
    return folder / relative;
}

std::string summary(const json& backup) {
    return counted(backup.at("files").size(), "file") + ", " + human_bytes(backup.at("bytes").get<double>());
}

void fetch(Session& session, const json& backup, const std::string& resource, const std::string& folder) {
    for (const json& file : backup.at("files")) {
        const std::string path = file.at("path").get<std::string>();
        const uint64_t bytes =
            download(session, resource + "/file?path=" + percent_encode(path), place_below(folder, path).string());
        if (bytes != file.at("bytes").get<uint64_t>())
            throw Failure(ExitCode::LocalFile, path + " has " + std::to_string(bytes) + " bytes of " +
                                                   file.at("bytes").dump() + ": the backup is not whole");
    }
    OutputFile list(fs::path(folder) / kListName);
    list.write(backup.dump(2) + "\n");
    list.publish();
}

ExitCode back_up(Session& session, const std::string& folder) {
    umask(S_IRWXG | S_IRWXO);  // as the data folder itself: nobody else's to read
    require_empty_folder(folder);
    const json backup = session.daemon().send("POST", "/v1/backups", nullptr, Repeat::Safely);
    const std::string resource = resource_path("backups", backup.at("id").get<std::string>());
    const auto release = [&] { session.daemon().send("DELETE", resource, nullptr, Repeat::Safely); };
    try {
        fetch(session, backup, resource, folder);
    } catch (...) {
        try {
            release();
        } catch (const Failure&) {  // the next backup takes its place
        }
        throw;
    }
    release();
    if (session.json_output)
        session.print_json(backup);
    else
        std::cout << folder << ": " << summary(backup) << '\n';
    return ExitCode::Ok;
}

ExitCode restore(Session& session, const std::string& folder, const std::string& data) {
    umask(S_IRWXG | S_IRWXO);
    std::ifstream list(fs::path(folder) / kListName);
    const json backup = json::parse(list, nullptr, false);
    if (!backup.is_object() || !backup.contains("files"))
        throw Failure(ExitCode::LocalFile, folder + " is no whole backup: it has no " + kListName);
    for (const json& file : backup.at("files")) {  // all of it is there, before anything is written
        const fs::path from = fs::path(folder) / file.at("path").get<std::string>();
        std::error_code error;
        const uintmax_t bytes = fs::file_size(from, error);
        if (error || bytes != file.at("bytes").get<uintmax_t>())
            throw Failure(ExitCode::LocalFile,
                          from.string() + (error ? " is missing" : " has another size") + ": the backup is not whole");
    }
    require_empty_folder(data);
    for (const json& file : backup.at("files")) {
        const std::string path = file.at("path").get<std::string>();
        std::error_code error;
        if (!fs::copy_file(fs::path(folder) / path, place_below(data, path), error))
            throw Failure(ExitCode::LocalFile, "cannot copy " + path + ": " + error.message());
    }
    sync();
    if (session.json_output)
        session.print_json(backup);
    else
        std::cout << data << ": " << summary(backup) << "; start it with photond --data " << data
                  << ", or look at it first with photond --check --data " << data << '\n';
    return ExitCode::Ok;
}

}  // namespace

void add_backup_commands(CLI::App& program, Session& session) {
    CLI::App* backup_command =
        program.add_subcommand("backup", "Copy everything the daemon keeps, as it is at one moment, while jobs run on");
    const auto folder = std::make_shared<std::string>();
    backup_command->add_option("folder", *folder, "a new folder")->required()->type_name("FILE");
    backup_command->callback(
        [&session, folder] { session.action = [&session, folder] { return back_up(session, *folder); }; });

    CLI::App* restore_command =
        program.add_subcommand("restore", "Put a backup into the data folder of a daemon that is to be started on it");
    const auto folders = std::make_shared<std::pair<std::string, std::string>>();
    restore_command->add_option("backup", folders->first, "a folder that backup has filled")
        ->required()
        ->type_name("FILE");
    restore_command->add_option("data", folders->second, "a new folder, for photond --data")
        ->required()
        ->type_name("FILE");
    restore_command->callback([&session, folders] {
        session.action = [&session, folders] { return restore(session, folders->first, folders->second); };
    });
}

}  // namespace photond::cli
