#include "server/store/job_counts.h"

namespace qray::server {

Result<JobCounts> count_jobs(Database& db) {
  JobCounts counts;
  const Database::Session session(db);
  Query states(session.handle(), "SELECT state, COUNT(*) FROM jobs GROUP BY state");
  while (states.next()) counts.by_state[states.text(0)] = states.integer(1);
  if (Status s = states.status(); !s.ok()) return s.error();
  Query oldest(session.handle(), "SELECT MIN(created_ms) FROM jobs WHERE state = 'queued'");
  if (oldest.next() && !oldest.is_null(0)) counts.oldest_queued_ms = oldest.integer(0);
  if (Status s = oldest.status(); !s.ok()) return s.error();
  return counts;
}

}  // namespace qray::server
