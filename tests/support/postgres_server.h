// A PostgreSQL of the test's own: made in a scratch folder by a user without rights, reached by a
// socket there, gone afterwards. One a test process, started when it is first asked for.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace qray::test {

class PostgresServer {
 public:
  // Null: there is no PostgreSQL 15 here; skip the test with why().
  static PostgresServer* instance();
  static const char* why();

  // Of an empty schema of its own in the one database; `line`: a folder with another socket to it.
  std::string url(const std::string& schema, const std::filesystem::path& line = {}) const;
  std::filesystem::path socket() const { return folder_ / ".s.PGSQL.5432"; }
  std::string new_schema();
  // Of a database of its own, with what `like` has, which nobody uses (empty: nothing).
  std::string url_of(const std::string& database) const;
  std::string new_database(const std::string& like = "");
  void run(const std::string& sql);  // throws where it fails

  void start();
  void stop_at_once();  // pg_ctl stop -m immediate: as if the machine had lost its power
  const std::filesystem::path& folder() const { return folder_; }

  ~PostgresServer();

 private:
  PostgresServer() = default;
  bool prepare();

  std::filesystem::path folder_;
  pid_t process_ = -1;
  int schemas_ = 0;
};

}  // namespace qray::test
