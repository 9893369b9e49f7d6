#include "server/postgres/libpq.h"

#include <dlfcn.h>

namespace qray::server {
namespace {

constexpr const char* kLibrary = "libpq.so.5";

Result<Libpq> load_library() {
  void* library = ::dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!library)
    return Error{
        ErrorCode::kUnsupported,
        "a store on PostgreSQL needs libpq5, which is not installed: " + std::string(::dlerror()),
        "--store"};
  Libpq pq;
  std::string missing;
  const auto find = [&](const char* name, auto& function) {
    function =
        reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
    if (!function) missing = name;
  };
  find("PQconnectdbParams", pq.connect);
  find("PQconninfoParse", pq.parse);
  find("PQconninfoFree", pq.free_info);
  find("PQfreemem", pq.free_memory);
  find("PQfinish", pq.finish);
  find("PQstatus", pq.status);
  find("PQerrorMessage", pq.error_message);
  find("PQsetnonblocking", pq.set_nonblocking);
  find("PQsocket", pq.socket);
  find("PQsendQuery", pq.send_query);
  find("PQsendQueryParams", pq.send_query_params);
  find("PQflush", pq.flush);
  find("PQconsumeInput", pq.consume_input);
  find("PQisBusy", pq.is_busy);
  find("PQgetResult", pq.get_result);
  find("PQnotifies", pq.notifies);
  find("PQclear", pq.clear);
  find("PQresultStatus", pq.result_status);
  find("PQresultErrorField", pq.result_error_field);
  find("PQresultErrorMessage", pq.result_error_message);
  find("PQntuples", pq.ntuples);
  find("PQgetisnull", pq.getisnull);
  find("PQgetvalue", pq.getvalue);
  find("PQgetlength", pq.getlength);
  find("PQsetNoticeProcessor", pq.set_notice_processor);
  if (!missing.empty())
    return Error{ErrorCode::kUnsupported, std::string(kLibrary) + " has no " + missing, "--store"};
  return pq;
}

}  // namespace

Result<const Libpq*> Libpq::load() {
  static const Result<Libpq> loaded = load_library();
  if (!loaded.ok()) return loaded.error();
  return &loaded.value();
}

}  // namespace qray::server
