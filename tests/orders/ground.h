// What outlives the lives of an order's server: its data folder and its records. Made once in the
// process that tries orders.
#pragma once

#include <filesystem>
#include <string>

#include "server/store/scene_store.h"
#include "tests/support/postgres_server.h"
#include "tests/support/scratch.h"

namespace qray::server::test {

class Ground {
 public:
  static Ground& instance();

  // From now on records are there, in a schema for each order; before, in SQLite.
  void use(qray::test::PostgresServer& server) { postgres_ = &server; }
  // The folder and the records, with nothing in them.
  void make_anew();
  // Between two lives: what the one before ran is nobody's any more.
  void end_leases();

  const std::filesystem::path& data() const { return data_; }
  const std::string& store() const { return store_; }  // as Config::store
  SceneStore& scenes() { return scenes_; }

 private:
  Ground();

  qray::test::ScratchFolder scratch_;
  const std::filesystem::path fresh_ = scratch_ / "fresh", data_ = scratch_ / "data";
  qray::test::PostgresServer* postgres_ = nullptr;
  std::string schema_, store_;
  SceneStore scenes_{scratch_ / "scenes", 1, size_t{1} << 30};
};

}  // namespace qray::server::test
