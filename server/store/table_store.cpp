#include "server/store/table_store.h"

#include "core/base/file.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxTableBytes = uint64_t{4} << 30;
}  // namespace

Result<std::unique_ptr<TableStore>> TableStore::open(TableIndex& index, fs::path data,
                                                     size_t max_bytes) {
  for (const char* folder : {"tables", "quarantine"}) {
    std::error_code ec;
    fs::create_directories(data / folder, ec);
    if (ec) return Error{ErrorCode::kIo, ec.message(), (data / folder).string()};
  }
  return std::unique_ptr<TableStore>(new TableStore(index, std::move(data), max_bytes));
}

fs::path TableStore::file_of(const std::string& id) const {
  return data_ / "tables" / (id + ".qrt");
}

Result<uint64_t> TableStore::write(const TableFile& table) {
  const Bytes bytes = encode_table(table);
  if (Status s = write_file_atomic(file_of(table.header.id), bytes); !s.ok()) return s.error();
  return bytes.size();
}

TableRow TableStore::row_of(const TableFile& table, proto::TableInfo info, uint64_t bytes) {
  info.bytes = bytes;
  return {std::move(info), {table.header.geometry, table.header.materials, table.header.lights}};
}

Status TableStore::add(const TableFile& table, proto::TableInfo info) {
  Result<uint64_t> bytes = write(table);
  if (!bytes.ok()) return bytes.error();
  return index_.add(row_of(table, std::move(info), bytes.value()));
}

Result<MappedFile> TableStore::open_file(const std::string& id) const {
  if (const Result<proto::TableInfo> known = find(id); !known.ok()) return known.error();
  return MappedFile::open(file_of(id), kMaxTableBytes);
}

Result<TableFile> TableStore::load(const std::string& id) {
  Result<Bytes> bytes = read_file(file_of(id), kMaxTableBytes);
  if (!bytes.ok()) {
    if (bytes.error().code == ErrorCode::kNotFound)  // its record serves nobody
      if (Status gone = quarantine(id); !gone.ok()) return gone.error();
    return bytes.error();
  }
  Result<TableFile> table = decode_table(bytes.value());
  if (table.ok() && table.value().header.id != id) {
    table = Error{ErrorCode::kCorrupt, "holds the id " + table.value().header.id, id + ".qrt"};
  }
  if (!table.ok()) {
    if (Status moved = quarantine(id); !moved.ok()) return moved.error();
  }
  return table;
}

Status TableStore::remove(const std::string& id) {
  if (Status s = index_.remove(id); !s.ok()) return s;
  std::error_code ec;
  fs::remove(file_of(id), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), file_of(id).string()};
  return {};
}

Status TableStore::quarantine(const std::string& id) {
  std::error_code ec;
  fs::rename(file_of(id), data_ / "quarantine" / (id + ".qrt"), ec);
  if (ec && ec != std::errc::no_such_file_or_directory) {
    return Error{ErrorCode::kIo, ec.message(), file_of(id).string()};
  }
  return index_.forget(id);
}

}  // namespace qray::server
