#include "server/sqlite/sqlite_table_index.h"

#include "server/model/lines.h"
#include "server/store/job_move.h"

namespace qray::server {
namespace {

constexpr const char* kTableColumns =
    "id, scene, method, parents, created_ms, bytes, states, samples_seen, job";

proto::TableInfo read_table(const Query& row) {
  proto::TableInfo info;
  info.id = row.text(0);
  info.scene = row.text(1);
  info.method = row.text(2);
  info.parents = split_lines(row.text(3));
  info.created_ms = row.integer(4);
  info.bytes = static_cast<uint64_t>(row.integer(5));
  info.states = static_cast<uint64_t>(row.integer(6));
  info.samples_seen = static_cast<uint64_t>(row.integer(7));
  info.job = row.text(8);
  return info;
}

}  // namespace

Status SqliteTableIndex::add(const TableRow& row) {
  Database::Transaction transaction(db_);
  if (Status s = record(transaction, row); !s.ok()) return s;
  return transaction.commit();
}

// The same job makes the same table again (its id is a hash of what it holds): the newer record
// takes the older one's place.
Status SqliteTableIndex::record(Database::Session& session, const TableRow& row) {
  const proto::TableInfo& info = row.info;
  return Query(session.handle(),
               "INSERT OR REPLACE INTO tables(id, scene, method, parents, created_ms, bytes, "
               "states, samples_seen, job, geometry, materials, lights) "
               "VALUES(?,?,?,?,?,?,?,?,?,?,?,?)")
      .bind(info.id)
      .bind(info.scene)
      .bind(info.method)
      .bind(join_lines(info.parents))
      .bind(info.created_ms)
      .bind(info.bytes)
      .bind(info.states)
      .bind(info.samples_seen)
      .bind(info.job)
      .bind(row.scene.geometry.hex())
      .bind(row.scene.materials.hex())
      .bind(row.scene.lights.hex())
      .run();
}

Result<std::vector<proto::TableInfo>> SqliteTableIndex::list(size_t limit,
                                                             const std::string& before) const {
  const Database::Reading session(db_);
  int64_t below = INT64_MAX;
  if (!before.empty()) {
    Query number(session.handle(), "SELECT number FROM tables WHERE id=?");
    number.bind(before);
    if (!number.next())
      return number.status().ok() ? Error{ErrorCode::kNotFound, "no table " + before, "/before"}
                                  : number.status().error();
    below = number.integer(0);
  }
  const std::string sql = std::string("SELECT ") + kTableColumns +
                          " FROM tables WHERE number < ? ORDER BY number DESC LIMIT ?";
  Query query(session.handle(), sql.c_str());
  query.bind(below).bind(static_cast<int64_t>(limit));
  std::vector<proto::TableInfo> tables;
  while (query.next()) tables.push_back(read_table(query));
  if (Status s = query.status(); !s.ok()) return s.error();
  return tables;
}

Result<std::vector<std::string>> SqliteTableIndex::ids() const {
  const Database::Reading reading(db_);
  Query query(reading.handle(), "SELECT id FROM tables");
  std::vector<std::string> ids;
  while (query.next()) ids.push_back(query.text(0));
  if (Status s = query.status(); !s.ok()) return s.error();
  return ids;
}

Result<proto::TableInfo> SqliteTableIndex::find(const std::string& id) const {
  const Database::Reading session(db_);
  const std::string sql = std::string("SELECT ") + kTableColumns + " FROM tables WHERE id=?";
  Query query(session.handle(), sql.c_str());
  query.bind(id);
  if (query.next()) return read_table(query);
  if (Status s = query.status(); !s.ok()) return s.error();
  return Error{ErrorCode::kNotFound, "no table " + id, ""};
}

Result<std::vector<std::string>> SqliteTableIndex::fitting(std::string_view method,
                                                           const SceneHash& scene,
                                                           size_t limit) const {
  const Database::Reading session(db_);
  Query query(session.handle(),
              "SELECT id FROM tables WHERE method=? AND geometry=? AND materials=? AND lights=? "
              "ORDER BY samples_seen DESC, number DESC LIMIT ?");
  query.bind(std::string(method))
      .bind(scene.geometry.hex())
      .bind(scene.materials.hex())
      .bind(scene.lights.hex())
      .bind(static_cast<int64_t>(limit));
  std::vector<std::string> ids;
  while (query.next()) ids.push_back(query.text(0));
  if (Status s = query.status(); !s.ok()) return s.error();
  return ids;
}

Status SqliteTableIndex::remove(const std::string& id) {
  Database::Transaction transaction(db_);
  Query user(transaction.handle(),
             "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') AND "
             "json_valid(request) AND json_extract(request, '$.table')=? LIMIT 1");
  user.bind(id);
  if (user.next()) return table_is_named({static_cast<uint64_t>(user.integer(0))});
  if (Status s = user.status(); !s.ok()) return s;
  Query gone(transaction.handle(), "DELETE FROM tables WHERE id=? RETURNING id");
  gone.bind(id);
  if (!gone.next())
    return gone.status().ok() ? Error{ErrorCode::kNotFound, "no table " + id, ""} : gone.status();
  if (Status s = gone.run(); !s.ok()) return s;
  return transaction.commit();
}

Status SqliteTableIndex::forget(const std::string& id) {
  Database::Session session(db_);
  return Query(session.handle(), "DELETE FROM tables WHERE id=?").bind(id).run();
}

}  // namespace qray::server
