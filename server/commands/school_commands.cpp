#include "server/commands/school_commands.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "common/base/uuid.h"
#include "server/app/data_folder.h"
#include "server/app/school_folder.h"
#include "server/commands/admin.h"
#include "server/commands/command_line.h"
#include "server/commands/console_progress.h"
#include "server/commands/say.h"
#include "server/commands/upkeep.h"
#include "server/storage/school/delete_store.h"
#include "server/training/names.h"

namespace enamel::server::app {
namespace {

// A server reads the list every two seconds, and somebody may take a minute to read a large answer;
// a server that died holds a school's rows for 20 s.
constexpr std::chrono::seconds kLetGo{90};

Result<std::unique_ptr<Store>> OpenInstallation(const std::filesystem::path& data) {
  if (const auto installation = InstallationOf(data)) {
    return Status(
        Code::kInvalidInput,
        "expected an installation's data folder, found a school's; name " + installation->string());
  }
  return OpenForCommand(data);
}

Result<SchoolRow> SchoolNamed(SchoolRows& schools, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(const auto all, schools.Schools());
  const auto found = std::ranges::find(all, name, &SchoolRow::name);
  if (found != all.end()) return *found;
  return Status(Code::kNotFound, "there is no school \"" + name + "\"; school list shows them",
                "name");
}

std::string HostsText(const SchoolRow& row) {
  std::string out;
  for (const std::string& host : row.hosts) out += (out.empty() ? "" : ", ") + host;
  return out;
}

Status SetState(const SchoolCommand& command, SchoolState state) {
  const bool suspended = state == SchoolState::kSuspended;
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenInstallation(command.data));
  ENAMEL_ASSIGN_OR_RETURN(SchoolRow row, SchoolNamed(store->schools, command.name));
  if (row.state == state) {
    Say("{} is {} already\n", row.name, SchoolStateName(state));
    return Status::Ok();
  }
  row.state = state;
  ENAMEL_RETURN_IF_ERROR(store->schools.ChangeSchool(row, kCommandLine));
  if (suspended) {
    Say("{} is suspended: within seconds nobody can sign in; all data is kept, and stations keep "
        "what they record\n",
        row.name);
  } else {
    Say("{} is served again within seconds\n", row.name);
  }
  return Status::Ok();
}

// Of a school that is being made: its data, and its first admin.
Status MakeData(const SchoolCommand& command, const SchoolRow& row) {
  ENAMEL_RETURN_IF_ERROR(EnsureSchoolFolder(command.data, row, SchoolData::kMake).status());
  const std::filesystem::path folder = SchoolFolder(command.data, row.name);
  ENAMEL_RETURN_IF_ERROR(OpenOrMake(folder).status());
  if (command.admin.empty()) return Status::Ok();
  return AddPerson(folder, {command.admin, "", "admin", "", false});
}

}  // namespace

Status AddSchool(const SchoolCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenInstallation(command.data));
  // A school's identity is derived from the installation's.
  ENAMEL_RETURN_IF_ERROR(EnsureMatchingIdentity(command.data, store->identity).status());
  // Checks the arguments before creating anything.
  if (!command.admin.empty()) ENAMEL_RETURN_IF_ERROR(CheckedLogin(command.admin).status());
  SchoolRow row;
  row.name = command.name;
  row.id = Uuid::New();
  row.hosts = command.hosts;
  // Listed first: a folder that no list names would be in the way of the next try. No server opens
  // one that is half made.
  row.state = SchoolState::kBeingMade;
  ENAMEL_RETURN_IF_ERROR(store->schools.AddSchool(row, kCommandLine));
  if (Status made = MakeData(command, row); !made.ok()) {
    return {made.code(), made.message() +
                             ". The school is listed and half made; when the cause is "
                             "gone: school delete " +
                             row.name + " --confirm " + row.name + ", then add it again"};
  }
  row.state = SchoolState::kServed;
  ENAMEL_RETURN_IF_ERROR(store->schools.ChangeSchool(row, kCommandLine));
  Say("{} is served within seconds as {}; its data folder, for other commands: {}\n", row.name,
      HostsText(row), SchoolFolder(command.data, row.name).string());
  return Status::Ok();
}

Status ListSchools(const SchoolCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenInstallation(command.data));
  ENAMEL_ASSIGN_OR_RETURN(const auto all, store->schools.Schools());
  for (const SchoolRow& row : all) {
    Say("{:<32}  {:<13}  {}  {}\n", row.name, SchoolStateName(row.state), HostsText(row),
        SchoolFolder(command.data, row.name).string());
  }
  if (all.empty()) Say("no other schools; school add makes one\n");
  return Status::Ok();
}

Status SetSchoolHosts(const SchoolCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenInstallation(command.data));
  ENAMEL_ASSIGN_OR_RETURN(SchoolRow row, SchoolNamed(store->schools, command.name));
  row.hosts = command.hosts;
  ENAMEL_RETURN_IF_ERROR(store->schools.ChangeSchool(row, kCommandLine));
  Say("{} is {} from now on\n", row.name, HostsText(row));
  return Status::Ok();
}

Status SuspendSchool(const SchoolCommand& command) {
  return SetState(command, SchoolState::kSuspended);
}
Status ResumeSchool(const SchoolCommand& command) {
  return SetState(command, SchoolState::kServed);
}

Status ExportSchool(const SchoolCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenInstallation(command.data));
  ENAMEL_ASSIGN_OR_RETURN(const SchoolRow row, SchoolNamed(store->schools, command.name));
  ENAMEL_RETURN_IF_ERROR(EnsureSchoolFolder(command.data, row, SchoolData::kExpect).status());
  BackupCommand backup;
  backup.data = SchoolFolder(command.data, row.name);
  backup.target = command.target;
  backup.json = command.json;
  ENAMEL_RETURN_IF_ERROR(Backup(backup));
  Say("enamel-server restore {} --data FOLDER makes a separate installation of it; its stations "
      "must enrol again\n",
      command.target.string());
  return Status::Ok();
}

Status RemoveSchool(const SchoolCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenInstallation(command.data));
  ENAMEL_ASSIGN_OR_RETURN(SchoolRow row, SchoolNamed(store->schools, command.name));
  if (command.confirm != row.name) {
    return {Code::kConflict, "this deletes all data of " + row.name +
                                 ", and only a backup brings it back; to go ahead, add --confirm " +
                                 row.name};
  }
  if (row.state == SchoolState::kServed) {
    return {Code::kConflict,
            "expected a school that is suspended, found one that is served; school "
            "suspend " +
                row.name + " first"};
  }
  // Nobody resumes it from now on: it may be half gone.
  row.state = SchoolState::kBeingDeleted;
  ENAMEL_RETURN_IF_ERROR(store->schools.ChangeSchool(row, kCommandLine));
  const auto until = std::chrono::steady_clock::now() + kLetGo;
  Status deleted = DeleteSchool(command.data, row);
  {
    ConsoleProgress progress;
    for (uint64_t waited = 0;
         deleted.field() == kServerHasIt && std::chrono::steady_clock::now() < until; ++waited) {
      progress("waiting for servers to let go", waited, kLetGo.count());
      std::this_thread::sleep_for(std::chrono::seconds(1));
      deleted = DeleteSchool(command.data, row);
    }
  }
  ENAMEL_RETURN_IF_ERROR(deleted);
  ENAMEL_RETURN_IF_ERROR(store->schools.RemoveSchool(row.name, kCommandLine));
  Say("{} is deleted\n", row.name);
  return Status::Ok();
}

void DeclareSchools(CommandGroup root) {
  auto* school =
      root.parent.add_subcommand("school", "Add and manage other schools of an installation");
  school->require_subcommand(1);
  const CommandGroup group{*school, root.chosen};
  const auto declare = [&](const std::string& name, const std::string& help, auto run) {
    auto declared = Declare<SchoolCommand>(group, name, help, run);
    AddData(declared.cmd, declared.options.data)->description("Data folder of the installation");
    return declared;
  };
  const auto named = [](CLI::App* cmd, SchoolCommand& o) {
    cmd->add_option("name", o.name, "The school's: 1 to 32 of a-z 0-9 -")->required();
  };
  const auto hosts = [](CLI::App* cmd, SchoolCommand& o) {
    cmd->add_option("--host", o.hosts, "Name its page is opened under (repeatable)")->required();
  };
  auto [add, a] = declare("add", "Make a school", AddSchool);
  named(add, a);
  hosts(add, a);
  add->add_option("--admin", a.admin,
                  "Login of its first admin, who gets a password for one sign-in");
  AddExample(add, "north --host north.example.edu --admin anna");
  AddExample(declare("list", "Show them", ListSchools).cmd, "");
  auto [rename, r] = declare("set-hosts", "Give one other host names", SetSchoolHosts);
  named(rename, r);
  hosts(rename, r);
  AddExample(rename, "north --host north.example.edu --host nord.example.edu");
  auto [suspend, s] = declare("suspend", "Let nobody in; keep all data", SuspendSchool);
  named(suspend, s);
  AddExample(suspend, "north");
  auto [resume, u] = declare("resume", "Serve one again", ResumeSchool);
  named(resume, u);
  AddExample(resume, "north");
  auto [exported, e] = declare("export", "Write a school's data as a backup", ExportSchool);
  named(exported, e);
  exported->add_option("--to", e.target, "Folder for it: absent or empty")->required();
  exported->add_option("--json", e.json, "Write the outcome to this file");
  AddExample(exported, "north --to /var/backups/enamel/north");
  auto [removed, d] = declare("delete", "Delete one, for good", RemoveSchool);
  named(removed, d);
  removed->add_option("--confirm", d.confirm, "Its name once more");
  AddExample(removed, "north --confirm north");
  // After its commands, which would inherit it.
  school->footer(
      "An installation serves its own school and any others that you add. Each has its\n"
      "own host name, people, stations and data; nobody in one school sees anything of another.\n"
      "A school's data folder, for other commands, is schools/NAME in that of the installation:\n"
      "  enamel-server admin enrol-code --data /var/lib/enamel/schools/north");
  AddExample(school, "add north --host north.example.edu");
}

}  // namespace enamel::server::app
