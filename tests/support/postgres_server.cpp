#include "tests/support/postgres_server.h"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace qray::test {
namespace {

namespace fs = std::filesystem;
const fs::path kPrograms = "/usr/lib/postgresql/15/bin";
constexpr const char* kNoRights = "nobody";  // PostgreSQL refuses to be root

// Starts a program as the user without rights where this one is root; -1: it did not start.
pid_t start_program(const fs::path& program, const std::vector<std::string>& args,
                    const fs::path& folder) {
  const passwd* user = ::getuid() == 0 ? ::getpwnam(kNoRights) : nullptr;
  const std::string log = folder / "log";
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  ::dup2(out, 1);
  ::dup2(out, 2);
  if (user &&
      (::setgroups(0, nullptr) != 0 || ::setgid(user->pw_gid) != 0 || ::setuid(user->pw_uid) != 0))
    ::_exit(126);
  ::prctl(PR_SET_PDEATHSIG, SIGQUIT);  // a test that is killed leaves no server
  if (::chdir(folder.c_str()) != 0) ::_exit(126);
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& arg : args) argv.push_back(const_cast<char*>(arg.c_str()));
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  ::_exit(127);
}

bool run_program(const fs::path& program, const std::vector<std::string>& args,
                 const fs::path& folder) {
  const pid_t child = start_program(program, args, folder);
  int status = -1;
  return child > 0 && ::waitpid(child, &status, 0) == child && status == 0;
}

}  // namespace

PostgresServer* PostgresServer::instance() {
  static const std::unique_ptr<PostgresServer> server = []() -> std::unique_ptr<PostgresServer> {
    std::unique_ptr<PostgresServer> made(new PostgresServer);
    return made->prepare() ? std::move(made) : nullptr;
  }();
  return server.get();
}

const char* PostgresServer::why() {
  return "PostgreSQL 15 is not in /usr/lib/postgresql/15: bash docker/install.sh test";
}

bool PostgresServer::prepare() {
  std::error_code ec;
  if (!fs::exists(kPrograms / "initdb", ec)) return false;
  std::string made = fs::temp_directory_path() / "qray-postgres-XXXXXX";
  if (!::mkdtemp(made.data())) return false;
  folder_ = made;
  if (const passwd* user = ::getuid() == 0 ? ::getpwnam(kNoRights) : nullptr)
    if (::chown(made.c_str(), user->pw_uid, user->pw_gid) != 0) return false;
  if (!run_program(
          kPrograms / "initdb",
          {"-D", folder_ / "db", "-U", "qray", "-A", "trust", "-N", "-E", "UTF8", "--locale=C"},
          folder_))
    throw std::runtime_error("initdb failed: see " + (folder_ / "log").string());
  start();
  return true;
}

void PostgresServer::start() {
  process_ = start_program(
      kPrograms / "postgres",
      {"-D", folder_ / "db", "-k", folder_, "-c", "listen_addresses=", "-c", "max_connections=400",
       "-c", "shared_buffers=64MB", "-c", "fsync=off"},  // the machine does not lose its power
      folder_);
  for (int tries = 0; tries < 600; ++tries) {
    if (run_program(kPrograms / "pg_isready", {"-h", folder_, "-d", "postgres", "-U", "qray"},
                    folder_))
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  throw std::runtime_error("PostgreSQL did not start: see " + (folder_ / "log").string());
}

void PostgresServer::stop_at_once() {
  if (process_ <= 0) return;
  ::kill(process_, SIGQUIT);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
}

PostgresServer::~PostgresServer() {
  stop_at_once();
  std::error_code ec;
  if (!folder_.empty()) fs::remove_all(folder_, ec);
}

std::string PostgresServer::url(const std::string& schema, const fs::path& line) const {
  return "postgresql:///postgres?user=qray&host=" + (line.empty() ? folder_ : line).string() +
         "&options=-csearch_path%3D" + schema;
}

std::string PostgresServer::new_schema() {
  const std::string schema = "test" + std::to_string(::getpid()) + "_" + std::to_string(++schemas_);
  run("CREATE SCHEMA " + schema);
  return schema;
}

std::string PostgresServer::url_of(const std::string& database) const {
  return "postgresql:///" + database + "?user=qray&host=" + folder_.string();
}

std::string PostgresServer::new_database(const std::string& like) {
  const std::string name = "db" + std::to_string(::getpid()) + "_" + std::to_string(++schemas_);
  run("CREATE DATABASE " + name + (like.empty() ? "" : " TEMPLATE " + like));
  return name;
}

void PostgresServer::run(const std::string& sql) {
  if (!run_program(
          kPrograms / "psql",
          {"-h", folder_, "-U", "qray", "-d", "postgres", "-v", "ON_ERROR_STOP=1", "-c", sql},
          folder_))
    throw std::runtime_error("psql failed: see " + (folder_ / "log").string());
}

}  // namespace qray::test
