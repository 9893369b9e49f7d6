// What of the service is kept in a database: one implementation's jobs, tables and webhooks.
#pragma once

#include "server/store/job_store.h"
#include "server/store/shared_jobs.h"
#include "server/store/shared_passes.h"
#include "server/store/webhook_store.h"

namespace qray::server {

class Records {
 public:
  virtual ~Records() = default;
  virtual JobStore& jobs() = 0;
  virtual TableIndex& tables() = 0;
  virtual WebhookStore& webhooks() = 0;
  virtual SharedJobs* shared() { return nullptr; }  // none: of one process alone
  virtual SharedPasses* passes() { return nullptr; }
};

}  // namespace qray::server
