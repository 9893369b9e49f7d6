#include "server/api/handlers_tables.h"

#include <spdlog/spdlog.h>

#include "core/guide/open_table.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr int kMostListed = 1000;

}  // namespace

void TableHandlers::add_to(Router& router) {
  router.add("GET", "/v1/tables", [this](auto& req, auto& res, auto&) { list(req, res); });
  router.add(
      "POST", "/v1/tables/merge", [this](auto& req, auto& res, auto&) { merge(req, res); },
      Scope::kAdmin);
  router.add_stream(
      "POST", "/v1/tables", tables_.max_bytes(),
      [this](auto& req, auto& res, auto&, auto& body) { upload(req, res, body); }, Scope::kAdmin);
  router.add("GET", "/v1/tables/{id}", [this](auto&, auto& res, auto& id) {
    const Result<proto::TableInfo> info = tables_.find(id);
    if (!info.ok()) return reply_error(res, info.error());
    reply_json(res, 200, proto::table_to_json(info.value()));
  });
  router.add("GET", "/v1/tables/{id}/file", [this](auto&, auto& res, auto& id) { file(res, id); });
  router.add("DELETE", "/v1/tables/{id}", [this](auto&, auto& res, auto& id) {
    if (Status removed = tables_.remove(id); !removed.ok())
      return reply_error(res, removed.error());
    res.status = 204;
  });
}

void TableHandlers::list(const httplib::Request& req, httplib::Response& res) const {
  const Result<int> limit = query_number(req, "limit", 1, kMostListed, kMostListed);
  if (!limit.ok()) return reply_error(res, limit.error());
  const std::string before = req.get_param_value("before");
  if (req.has_param("before") && !proto::is_id(before))
    return reply_error(res, {ErrorCode::kInvalid, "expected a table's id", "/before"});
  const size_t wanted = static_cast<size_t>(limit.value());
  Result<std::vector<proto::TableInfo>> tables = tables_.list(wanted + 1, before);
  if (!tables.ok()) return reply_error(res, tables.error());
  const bool more = tables.value().size() > wanted;
  if (more) tables.value().pop_back();
  reply_json(res, 200,
             proto::table_list_to_json(tables.value(), more ? tables.value().back().id : ""));
}

void TableHandlers::file(httplib::Response& res, const std::string& id) const {
  Result<MappedFile> file = tables_.open_file(id);
  if (!file.ok()) return reply_error(res, file.error());
  reply_file(res, std::move(file).value(), id + ".qrt", kBytesType);
}

void TableHandlers::upload(const httplib::Request& req, httplib::Response& res,
                           const httplib::ContentReader& body) {
  if (req.get_header_value("Content-Type") != kBytesType)
    return reply_problem(
        res,
        {415, "Wrong media type", std::string("expected a table's file as ") + kBytesType, {}});
  const std::string scene = req.get_param_value("scene");
  if (!scene.empty() && !proto::is_name(scene))
    return reply_error(res, {ErrorCode::kInvalid, "expected a scene's name", "/scene"});
  const std::unique_lock turn(uploading_, std::try_to_lock);
  if (!turn) return reply_problem(res, {503, "Busy", "another table is being uploaded", {}});
  Bytes bytes;
  bytes.reserve(req.get_header_value<uint64_t>("Content-Length"));
  const bool arrived = body([&](const char* data, size_t size) {
    bytes.insert(bytes.end(), data, data + size);
    return true;
  });
  if (!arrived) return reply_problem(res, {400, "Bad request", "the body did not arrive", {}});
  bool is_new = false;
  const Result<proto::TableInfo> info = uploaded(bytes, scene, is_new);
  if (!info.ok() && info.error().code == ErrorCode::kCorrupt)
    return reply_problem(res, {422, "Wrong table file", info.error().text(), {}});
  if (!info.ok()) return reply_error(res, info.error());
  res.set_header("Location", "/v1/tables/" + info.value().id);
  reply_json(res, is_new ? 201 : 200, proto::table_to_json(info.value()));
}

// All that `qray table verify` checks, since jobs will start from it.
Result<proto::TableInfo> TableHandlers::uploaded(std::span<const uint8_t> bytes,
                                                 const std::string& scene, bool& is_new) {
  const Result<TableFile> table = decode_table(bytes);
  if (!table.ok()) return table.error();
  const TableHeader& header = table.value().header;
  const auto opened = open_table(table.value(), tables_.max_bytes());
  if (!opened.ok()) return opened.error();
  const Result<TableCheck> check = check_table(table.value());
  if (!check.ok()) return check.error();
  if (const Result<proto::TableInfo> known = tables_.find(header.id); known.ok()) return known;
  const proto::TableInfo info{header.id,
                              scene,
                              header.method,
                              header.parents,
                              now_ms_(),
                              0,
                              check.value().guide->stats().states,
                              header.samples_seen,
                              ""};
  if (Status added = tables_.add(table.value(), info); !added.ok()) return added.error();
  is_new = true;
  return tables_.find(header.id);
}

void TableHandlers::merge(const httplib::Request& req, httplib::Response& res) {
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_merge_request(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  const auto& ids = std::get<std::vector<std::string>>(parsed);
  std::vector<proto::TableInfo> infos;
  for (size_t i = 0; i < ids.size(); ++i) {
    Result<proto::TableInfo> info = tables_.find(ids[i]);
    if (!info.ok())
      return reply_error(res,
                         {info.error().code, info.error().message, "/tables/" + std::to_string(i)});
    infos.push_back(std::move(info).value());
  }
  const std::unique_lock turn(merging_, std::chrono::seconds(10));
  if (!turn) return reply_problem(res, {503, "Busy", "other tables are being merged", {}});
  const Result<proto::TableInfo> info = merged(infos);
  if (!info.ok()) return reply_error(res, info.error());
  res.set_header("Location", "/v1/tables/" + info.value().id);
  reply_json(res, 201, proto::table_to_json(info.value()));
}

Result<proto::TableInfo> TableHandlers::merged(const std::vector<proto::TableInfo>& infos) {
  // All are in memory at once.
  uint64_t bytes = 0;
  for (const proto::TableInfo& info : infos) bytes += info.bytes;
  if (bytes > 2 * tables_.max_bytes())
    return Error{ErrorCode::kTooLarge,
                 "expected tables of at most " + std::to_string(2 * tables_.max_bytes()) +
                     " bytes in all, got " + std::to_string(bytes),
                 "/tables"};
  std::vector<TableFile> files;
  for (const proto::TableInfo& info : infos) {
    Result<TableFile> file = tables_.load(info.id);
    if (!file.ok()) {
      spdlog::error("table {}: {}", info.id, file.error().text());
      return Error{ErrorCode::kConflict, "table " + info.id + " cannot be read", ""};
    }
    files.push_back(std::move(file).value());
  }
  Result<MergedTable> merged = merge_tables(files, tables_.max_bytes());
  if (!merged.ok()) {
    if (merged.error().code != ErrorCode::kCorrupt) return merged.error();
    return Error{ErrorCode::kConflict, merged.error().message, merged.error().where};
  }
  const TableHeader& header = merged.value().file.header;
  const proto::TableInfo info{header.id,
                              infos[0].scene,
                              header.method,
                              header.parents,
                              now_ms_(),
                              0,
                              merged.value().states,
                              header.samples_seen,
                              ""};
  if (Status added = tables_.add(merged.value().file, info); !added.ok()) return added.error();
  return tables_.find(header.id);
}

}  // namespace qray::server
