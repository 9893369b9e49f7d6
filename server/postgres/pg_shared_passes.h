// Passes that several processes sample together (shared_passes.h), in tables that are not logged:
// a database that lost its power has them empty. Each call is one statement, one way there and
// back, but for joining.
#pragma once

#include "server/postgres/pg_database.h"
#include "server/store/shared_passes.h"

namespace qray::server {

class PgSharedPasses final : public SharedPasses {
 public:
  PgSharedPasses(PgDatabase& db, std::string worker) : db_(db), worker_(std::move(worker)) {}

  Status begin(const Pass& pass, const std::string& bits, int workers, const Bytes* guide) override;
  Result<Collected> collect(const Key& key, std::span<const size_t> here) override;
  Status reopen(const Key& key, std::span<const size_t> units) override;
  Status end(JobId job, uint64_t claim) override;
  Result<std::optional<Open>> find(const std::string& bits) override;
  Result<bool> join(const Open& job) override;
  Status leave(const Open& job) override;
  Result<std::optional<Pass>> next(const Open& job, const std::optional<Key>& than) override;
  Result<Bytes> load_guide(const Open& job, const std::string& guide) override;
  Result<std::optional<size_t>> take(const Key& key, double patience) override;
  Result<Put> put(const Key& key, const Unit& unit) override;
  const std::string& me() const override { return worker_; }
  Status put_aside(const std::string& worker, const std::string& why) override;
  Result<int> others_of_other_bits(const std::string& bits) override;

 private:
  PgDatabase& db_;
  const std::string worker_;
};

}  // namespace qray::server
