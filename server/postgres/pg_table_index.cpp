#include "server/postgres/pg_table_index.h"

#include "server/model/lines.h"
#include "server/store/job_move.h"

namespace qray::server {
namespace {

const std::string kPgTableColumns =
    "id, scene, method, parents, created_ms, bytes, states, samples_seen, job";

proto::TableInfo read_pg_table(const PgRows& rows, int row) {
  proto::TableInfo info;
  info.id = rows.text(row, 0);
  info.scene = rows.text(row, 1);
  info.method = rows.text(row, 2);
  info.parents = split_lines(rows.text(row, 3));
  info.created_ms = rows.integer(row, 4);
  info.bytes = rows.number(row, 5);
  info.states = rows.number(row, 6);
  info.samples_seen = rows.number(row, 7);
  info.job = rows.text(row, 8);
  return info;
}

Error no_table(const std::string& id, const char* where) {
  return {ErrorCode::kNotFound, "no table " + id, where};
}

std::vector<std::string> texts(const PgRows& rows) {
  std::vector<std::string> all;
  for (int row = 0; row < rows.size(); ++row) all.push_back(rows.text(row, 0));
  return all;
}

}  // namespace

Status PgTableIndex::add(const TableRow& row) {
  PgDatabase::Transaction transaction(db_);
  if (Status s = record(transaction, row); !s.ok()) return s;
  return transaction.commit();
}

// The same job makes the same table again (its id is a hash of what it holds): the newer record
// takes the older one's place.
Status PgTableIndex::record(PgDatabase::Transaction& transaction, const TableRow& row) {
  const proto::TableInfo& info = row.info;
  return transaction.change(
      "INSERT INTO tables VALUES(nextval('table_numbers'),$1,$2,$3,$4,$5,$6,$7,$8,$9,$10,$11,$12) "
      "ON CONFLICT(id) DO UPDATE SET number=excluded.number, scene=excluded.scene, "
      "method=excluded.method, parents=excluded.parents, created_ms=excluded.created_ms, "
      "bytes=excluded.bytes, states=excluded.states, samples_seen=excluded.samples_seen, "
      "job=excluded.job, geometry=excluded.geometry, materials=excluded.materials, "
      "lights=excluded.lights",
      {info.id, info.scene, info.method, join_lines(info.parents), info.created_ms, info.bytes,
       info.states, info.samples_seen, info.job, row.scene.geometry.hex(),
       row.scene.materials.hex(), row.scene.lights.hex()});
}

Result<std::vector<proto::TableInfo>> PgTableIndex::list(size_t limit,
                                                         const std::string& before) const {
  PgDatabase::Session session(db_);
  int64_t below = INT64_MAX;
  if (!before.empty()) {
    const Result<PgRows> number = session.run("SELECT number FROM tables WHERE id=$1", {before});
    if (!number.ok()) return number.error();
    if (number.value().empty()) return no_table(before, "/before");
    below = number.value().integer(0, 0);
  }
  const Result<PgRows> rows = session.run(
      "SELECT " + kPgTableColumns + " FROM tables WHERE number < $1 ORDER BY number DESC LIMIT $2",
      {below, uint64_t{limit}});
  if (!rows.ok()) return rows.error();
  std::vector<proto::TableInfo> tables;
  for (int row = 0; row < rows.value().size(); ++row)
    tables.push_back(read_pg_table(rows.value(), row));
  return tables;
}

Result<std::vector<std::string>> PgTableIndex::ids() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run("SELECT id FROM tables");
  if (!rows.ok()) return rows.error();
  return texts(rows.value());
}

Result<proto::TableInfo> PgTableIndex::find(const std::string& id) const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows =
      session.run("SELECT " + kPgTableColumns + " FROM tables WHERE id=$1", {id});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty()) return no_table(id, "");
  return read_pg_table(rows.value(), 0);
}

Result<std::vector<std::string>> PgTableIndex::fitting(std::string_view method,
                                                       const SceneHash& scene, size_t limit) const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT id FROM tables WHERE method=$1 AND geometry=$2 AND materials=$3 AND lights=$4 "
      "ORDER BY samples_seen DESC, number DESC LIMIT $5",
      {method, scene.geometry.hex(), scene.materials.hex(), scene.lights.hex(), uint64_t{limit}});
  if (!rows.ok()) return rows.error();
  return texts(rows.value());
}

Status PgTableIndex::remove(const std::string& id) {
  PgDatabase::Transaction transaction(db_);
  const Result<PgRows> user = transaction.run(
      "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') AND "
      "wanted_table=$1 LIMIT 1",
      {id});
  if (!user.ok()) return user.error();
  if (!user.value().empty()) return table_is_named({user.value().number(0, 0)});
  const Result<PgRows> gone = transaction.run("DELETE FROM tables WHERE id=$1 RETURNING id", {id});
  if (!gone.ok()) return gone.error();
  if (gone.value().empty()) return no_table(id, "");
  return transaction.commit();
}

Status PgTableIndex::forget(const std::string& id) {
  PgDatabase::Transaction transaction(db_);
  if (Status s = transaction.change("DELETE FROM tables WHERE id=$1", {id}); !s.ok()) return s;
  return transaction.commit();
}

}  // namespace qray::server
