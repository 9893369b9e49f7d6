#include "tests/orders/ground.h"

#include <spdlog/spdlog.h>
#include <sqlite3.h>

#include "server/sqlite/database.h"
#include "tests/crash/plain_pictures.h"
#include "tests/orders/look_up.h"
#include "tests/server/box_scene.h"

namespace qray::server::test {
namespace {

namespace fs = std::filesystem;

}  // namespace

Ground& Ground::instance() {
  static Ground ground;
  return ground;
}

Ground::Ground() : scratch_(fs::is_directory("/dev/shm") ? "/dev/shm" : fs::temp_directory_path()) {
  spdlog::set_level(spdlog::level::off);
  use_image_library(plain_pictures());
  look_functions_up();
  // One thread runs at a time, and none meets another inside SQLite: its locks are left out.
  sqlite3_config(SQLITE_CONFIG_SINGLETHREAD);
  write_text(scratch_ / "scenes/box/scene.json", kBoxScene);
  (void)scenes_.prepare("box");
  (void)Database::open((fs::create_directories(fresh_), fresh_ / "qray.sqlite"));
}

void Ground::make_anew() {
  fs::remove_all(data_);
  fs::copy(fresh_, data_, fs::copy_options::recursive);
  if (!postgres_) return;
  schema_ = postgres_->new_schema();
  store_ = postgres_->url(schema_);
}

void Ground::end_leases() {
  if (!postgres_) return;
  const std::string runs = schema_ + ".runs";
  postgres_->run("DO $$ BEGIN IF to_regclass('" + runs + "') IS NOT NULL THEN UPDATE " + runs +
                 " SET until=clock_timestamp() - interval '1 s'; END IF; END $$");
}

}  // namespace qray::server::test
