// Tables: files under <data>/tables/<id>.qrt, records in the database. Decides which table a job
// gets. A file that cannot be read is moved to <data>/quarantine. Any thread.
#pragma once

#include <filesystem>

#include "core/base/file.h"
#include "core/guide/guide.h"
#include "core/scene/scene.h"
#include "proto/messages.h"
#include "server/store/table_index.h"

namespace qray::server {

class TableStore {
 public:
  // A job's table may take `max_bytes` of memory.
  static Result<std::unique_ptr<TableStore>> open(TableIndex& index, std::filesystem::path data,
                                                  size_t max_bytes = kDefaultTableBytes);
  size_t max_bytes() const { return max_bytes_; }

  // Writes the file; its row then belongs into the transaction that says so.
  Result<uint64_t> write(const TableFile& table);  // the file's size, bytes
  static TableRow row_of(const TableFile& table, proto::TableInfo info, uint64_t bytes);

  // Both, for a table that no job's end says.
  Status add(const TableFile& table, proto::TableInfo info);

  // Newest first; those before a table (kNotFound), or all.
  Result<std::vector<proto::TableInfo>> list(size_t limit, const std::string& before = "") const {
    return index_.list(limit, before);
  }
  // As it is on disk. kNotFound.
  Result<MappedFile> open_file(const std::string& id) const;
  Result<std::vector<std::string>> ids() const { return index_.ids(); }
  Result<proto::TableInfo> find(const std::string& id) const {  // kNotFound
    return index_.find(id);
  }
  // Ids of tables that fit method and scene, at most `limit`: those that have seen the most first,
  // so that no job or session makes what the next one starts from worse.
  Result<std::vector<std::string>> fitting(std::string_view method, const SceneHash& scene,
                                           size_t limit) const {
    return index_.fitting(method, scene, limit);
  }
  // kCorrupt and kUnsupported: it has gone to quarantine. kNotFound: the file is not there.
  Result<TableFile> load(const std::string& id);
  // Deletes file and record. kNotFound; kConflict: a job that has not ended names it.
  Status remove(const std::string& id);
  // Takes the table out of use, and keeps its file for a look.
  Status quarantine(const std::string& id);

 private:
  TableStore(TableIndex& index, std::filesystem::path data, size_t max_bytes)
      : index_(index), data_(std::move(data)), max_bytes_(max_bytes) {}
  std::filesystem::path file_of(const std::string& id) const;

  TableIndex& index_;
  std::filesystem::path data_;
  size_t max_bytes_;
};

}  // namespace qray::server
